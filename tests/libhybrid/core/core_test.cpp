// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, the hybrid mapping authors
#include <gtest/gtest.h>

#include <limits>
#include <sstream>
#include <string>
#include <unordered_set>

#include "libhybrid/core/assignment.h"
#include "libhybrid/core/key.h"
#include "libhybrid/core/values.h"

namespace hybrid {
namespace {

/// The message of the Error that `function` throws; empty if it throws none.
template <class Function>
std::string error_of(Function&& function) {
  try {
    function();
  } catch (const Error& error) {
    return error.what();
  }
  return "";
}

TEST(Key, PacksLetterAndIndex) {
  const Key key('x', (1ULL << 56) - 1);
  EXPECT_EQ(key.letter(), 'x');
  EXPECT_EQ(key.index(), (1ULL << 56) - 1);
  EXPECT_EQ(to_string(Key('l', 12)), "l12");
  std::ostringstream out;
  out << Key('c', 0);
  EXPECT_EQ(out.str(), "c0");
}

TEST(Key, OrdersByLetterThenIndex) {
  EXPECT_LT(Key('a', 5), Key('b', 0));
  EXPECT_LT(Key('a', 5), Key('a', 6));
  EXPECT_NE(Key('a', 5), Key('b', 5));
  EXPECT_EQ(Key('a', 5), Key('a', 5));
  // The letter counts as unsigned, so that keys beyond ASCII sort last.
  EXPECT_LT(Key('z', 0), Key(static_cast<char>(0xe9), 0));
}

TEST(Key, HashSpreadsNeighbours) {
  std::unordered_set<std::size_t> buckets;
  for (int i = 0; i < 1000; ++i) {
    buckets.insert(std::hash<Key>{}(Key('x', i)) % 1024);
    buckets.insert(std::hash<Key>{}(Key('l', i)) % 1024);
  }
  EXPECT_GT(buckets.size(), 600u);  // 2000 random throws hit 880 of 1024
}

TEST(Values, InsertReadUpdateErase) {
  Values values;
  EXPECT_TRUE(values.empty());
  values.insert(Key('x', 0), SE2(1.0, 2.0, 0.5));
  values.insert(Key('l', 0), Eigen::Vector3d(1.0, 2.0, 3.0));
  EXPECT_EQ(values.size(), 2u);
  EXPECT_NEAR(values.at<SE2>(Key('x', 0)).angle(), 0.5, 1e-15);
  values.update(Key('l', 0), Eigen::Vector3d(4.0, 5.0, 6.0));
  EXPECT_EQ(values.at<Eigen::Vector3d>(Key('l', 0)).z(), 6.0);
  EXPECT_EQ(values.keys(), (std::vector<Key>{Key('x', 0), Key('l', 0)}));
  values.erase(Key('x', 0));
  EXPECT_FALSE(values.contains(Key('x', 0)));
  EXPECT_EQ(values.find(Key('x', 0)), -1);
  EXPECT_EQ(values.keys(), (std::vector<Key>{Key('l', 0)}));
}

TEST(Values, ErasedSlotsAreReusedByTheSameSize) {
  Values values;
  values.insert(Key('x', 0), SE2());
  values.insert(Key('x', 1), SE3());
  const int slot = values.slot(Key('x', 0));
  values.erase(Key('x', 0));
  EXPECT_FALSE(values.occupied(slot));
  values.insert(Key('x', 2), SE3());  // another size: a new slot
  EXPECT_NE(values.slot(Key('x', 2)), slot);
  values.insert(Key('x', 3), SO3());  // four doubles, as SE2
  EXPECT_EQ(values.slot(Key('x', 3)), slot);
  EXPECT_EQ(values.type(slot), Variable<SO3>::type());
  EXPECT_EQ(values.key(slot), Key('x', 3));
  EXPECT_EQ(values.slot_count(), 3);
  EXPECT_EQ(values.at<SO3>(Key('x', 3)).log().norm(), 0.0);
}

TEST(Values, MemoryDoesNotGrowWithAWindow) {
  Values values;
  for (int i = 0; i < 1000; ++i) {
    values.insert(Key('x', i), SE3());
    if (i >= 10) values.erase(Key('x', i - 10));
  }
  EXPECT_EQ(values.slot_count(), 11);
}

TEST(Values, ErrorsNameTheVariable) {
  Values values;
  values.insert(Key('x', 7), SE2());
  EXPECT_EQ(error_of([&] { values.insert(Key('x', 7), SE2()); }), "variable x7 exists already");
  EXPECT_EQ(error_of([&] { values.at<SE3>(Key('x', 7)); }), "variable x7 is SE2, not SE3");
  EXPECT_EQ(error_of([&] { values.update(Key('x', 7), Eigen::Vector3d::Zero().eval()); }),
            "variable x7 is SE2, not vector of 3");
  EXPECT_EQ(error_of([&] { values.at<SE2>(Key('x', 8)); }), "variable x8 has no value");
  EXPECT_EQ(error_of([&] { values.erase(Key('x', 8)); }), "variable x8 has no value");
}

TEST(Values, RefusesWhatIsNotFinite) {
  for (double bad :
       {std::numeric_limits<double>::quiet_NaN(), std::numeric_limits<double>::infinity()}) {
    Values values;
    EXPECT_EQ(error_of([&] { values.insert(Key('l', 1), Eigen::Vector2d(0.0, bad)); }),
              "initial value of l1 is not finite");
    EXPECT_TRUE(values.empty());
    EXPECT_EQ(values.slot_count(), 0);
  }
}

TEST(Values, CopiesAreIndependent) {
  Values values;
  values.insert(Key('x', 0), SE2());
  Values copy = values;
  copy.update(Key('x', 0), SE2(1.0, 0.0, 0.0));
  EXPECT_EQ(values.at<SE2>(Key('x', 0)).x(), 0.0);
}

TEST(VariableType, NamesItself) {
  EXPECT_EQ(to_string(Variable<SO2>::type()), "SO2");
  EXPECT_EQ(to_string(Variable<SE2>::type()), "SE2");
  EXPECT_EQ(to_string(Variable<SO3>::type()), "SO3");
  EXPECT_EQ(to_string(Variable<SE3>::type()), "SE3");
  EXPECT_EQ(to_string(Variable<Eigen::Vector2d>::type()), "vector of 2");
  EXPECT_NE(Variable<SE2>::type(), Variable<SO3>::type());
  EXPECT_NE(Variable<SO3>::type(), Variable<Eigen::Vector3d>::type());
}

TEST(Assignment, SetReadErase) {
  Assignment assignment;
  assignment.set(Key('c', 1), 3);
  EXPECT_EQ(assignment.at(Key('c', 1)), 3);
  assignment.set(Key('c', 1), 2);
  EXPECT_EQ(assignment.at(Key('c', 1)), 2);
  EXPECT_EQ(assignment.size(), 1u);
  Assignment other = assignment;
  EXPECT_EQ(assignment, other);
  other.set(Key('c', 2), 0);
  EXPECT_FALSE(assignment == other);
  other.erase(Key('c', 2));
  EXPECT_EQ(assignment, other);
  EXPECT_EQ(error_of([&] { assignment.at(Key('c', 9)); }), "discrete variable c9 has no value");
}

}  // namespace
}  // namespace hybrid
