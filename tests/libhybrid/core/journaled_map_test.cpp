// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, the hybrid mapping authors

#include "libhybrid/core/journaled_map.h"

#include <gtest/gtest.h>

#include <map>
#include <string>

namespace hybrid {
namespace {

using Entries = std::map<int, std::string>;

TEST(JournaledMap, TakesBackWhatWasChangedSinceTheCommit) {
  JournaledMap<int, std::string> map;
  map.set(1, "one");
  map.set(2, "two");
  map.commit();
  const Entries committed = map.entries();
  map.set(1, "first");
  map.set(1, "again");
  map.erase(2);
  map.set(3, "three");
  map.erase(4);
  EXPECT_EQ(map.entries(), (Entries{{1, "again"}, {3, "three"}}));
  map.roll_back();
  EXPECT_EQ(map.entries(), committed);
  EXPECT_EQ(map.changes(), 0U);
}

TEST(JournaledMap, TakesBackTheLastChangesAlone) {
  JournaledMap<int, std::string> map;
  map.set(1, "one");
  const std::size_t first = map.changes();
  map.set(1, "other");
  map.set(2, "two");
  map.roll_back(first);
  EXPECT_EQ(map.entries(), (Entries{{1, "one"}}));
  map.roll_back();
  EXPECT_TRUE(map.entries().empty());
  EXPECT_EQ(map.find(1), nullptr);
}

}  // namespace
}  // namespace hybrid
