// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, the hybrid mapping authors
#include "libhybrid/hybrid/handle.h"

#include <gtest/gtest.h>

#include <map>
#include <random>
#include <string>

namespace hybrid {
namespace {

TEST(HandleList, NamesWhatWasAdded) {
  HandleList<std::string> list(FactorKind::kDiscrete);
  const Handle a = list.add("a");
  const Handle b = list.add("b");
  EXPECT_TRUE(a.valid());
  EXPECT_EQ(a.kind, FactorKind::kDiscrete);
  EXPECT_FALSE(a == b);
  EXPECT_EQ(list.at(a), "a");
  EXPECT_EQ(list.remove(a), "a");
  EXPECT_EQ(list.size(), 1u);
  EXPECT_EQ(list.at(b), "b");
}

TEST(HandleList, RefusesStaleAndForeignHandles) {
  HandleList<int> list(FactorKind::kContinuous);
  const Handle first = list.add(1);
  list.remove(first);
  const Handle second = list.add(2);
  EXPECT_EQ(second.index, first.index) << "the place is reused";
  EXPECT_FALSE(list.contains(first));
  EXPECT_THROW(list.at(first), Error);
  EXPECT_THROW(list.remove(first), Error);
  EXPECT_EQ(list.at(second), 2);
  Handle foreign = second;
  foreign.kind = FactorKind::kHybrid;
  EXPECT_FALSE(list.contains(foreign));
  EXPECT_FALSE(list.contains(Handle{}));
  EXPECT_THROW(list.at(Handle{FactorKind::kContinuous, 99, 1}), Error);
}

TEST(HandleList, AgreesWithAMapUnderRandomChange) {
  HandleList<int> list(FactorKind::kContinuous);
  std::map<int, Handle> alive;
  std::vector<Handle> dead;
  std::mt19937 rng(1);
  std::size_t most = 0;
  for (int i = 0; i < 5000; ++i) {
    if (alive.empty() || rng() % 2 == 0) {
      alive[i] = list.add(i);
    } else {
      auto it = std::next(alive.begin(), rng() % alive.size());
      EXPECT_EQ(list.remove(it->second), it->first);
      dead.push_back(it->second);
      alive.erase(it);
    }
    most = std::max(most, alive.size());
  }
  EXPECT_EQ(list.size(), alive.size());
  EXPECT_EQ(list.capacity(), most);
  for (const auto& [value, handle] : alive) EXPECT_EQ(list.at(handle), value);
  for (Handle handle : dead) EXPECT_FALSE(list.contains(handle));
  std::size_t visited = 0;
  list.for_each([&](Handle handle, int value) {
    EXPECT_TRUE(alive.at(value) == handle);
    ++visited;
  });
  EXPECT_EQ(visited, alive.size());
}

}  // namespace
}  // namespace hybrid
