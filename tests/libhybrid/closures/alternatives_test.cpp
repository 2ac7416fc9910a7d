// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, the hybrid mapping authors
#include "libhybrid/closures/alternatives.h"

#include <gtest/gtest.h>

#include "libhybrid/core/error.h"

namespace hybrid {
namespace {

using Set = std::vector<std::size_t>;

TEST(Alternatives, ThoseOfASetKnowEachOther) {
  Alternatives alternatives;
  for (const std::size_t first : {0, 0, 2, 0, 2, 5}) alternatives.add(first);
  EXPECT_EQ(alternatives.set_of(0), (Set{0, 1, 3}));
  EXPECT_EQ(alternatives.set_of(3), (Set{0, 1, 3}));
  EXPECT_EQ(alternatives.set_of(4), (Set{2, 4}));
  EXPECT_TRUE(alternatives.set_of(5).empty());   // alone
  EXPECT_TRUE(alternatives.set_of(99).empty());  // never added
  const auto third = [](std::size_t k) { return k == 3; };
  EXPECT_TRUE(alternatives.exclude(0, third));
  EXPECT_FALSE(alternatives.exclude(3, third));  // not by itself
  EXPECT_FALSE(alternatives.exclude(2, third));
}

TEST(Alternatives, AreForgottenAsIfTheyHadNotBeen) {
  Alternatives alternatives;
  for (const std::size_t first : {0, 0, 2, 0}) alternatives.add(first);
  alternatives.resize(2);
  EXPECT_EQ(alternatives.size(), 2U);
  EXPECT_EQ(alternatives.set_of(1), (Set{0, 1}));
  alternatives.resize(1);
  EXPECT_TRUE(alternatives.set_of(0).empty());
  alternatives.add(1);
  EXPECT_TRUE(alternatives.set_of(1).empty());
}

TEST(Alternatives, OfWhatComesLaterAreRefused) {
  Alternatives alternatives;
  EXPECT_THROW(alternatives.add(1), Error);
  EXPECT_EQ(alternatives.size(), 0U);
}

}  // namespace
}  // namespace hybrid
