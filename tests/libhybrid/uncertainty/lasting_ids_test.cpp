// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, the hybrid mapping authors
#include "libhybrid/uncertainty/lasting_ids.h"

#include <gtest/gtest.h>

#include "tests/libhybrid/uncertainty/driven_world.h"

namespace hybrid {
namespace {

DrivenWorld with_ids(bool tracker) {
  DrivenWorld world;
  world.has_ids = true;
  world.tracker = tracker;
  world.frames = 900;
  return world;
}

TEST(LastingIds, ThoseOfThingsReturnThoseOfATrackerDoNot) {
  const IdReturns lasting = count_id_returns(drive(with_ids(false)).frames);
  EXPECT_FALSE(lasting.are_of_a_tracker());
  EXPECT_GT(lasting.returned, 10U);
  const IdReturns tracker = count_id_returns(drive(with_ids(true)).frames);
  EXPECT_TRUE(tracker.are_of_a_tracker()) << tracker.due << " due, " << tracker.returned;
  EXPECT_EQ(tracker.returned, 0U);
}

// Numbers of rows: whatever the way is, they tell nothing.
TEST(LastingIds, AnIdForEachDetectionIsThatOfNoThing) {
  DrivenWorld world;
  world.turning = 0;
  DrivenLog log = drive(world);
  EXPECT_FALSE(count_id_returns(log.frames).are_of_a_tracker());  // no ids
  std::int64_t next = 0;
  for (MovedSightings& frame : log.frames) {
    for (auto& id : frame.ids) id = next++;
  }
  const IdReturns returns = count_id_returns(log.frames);
  EXPECT_EQ(returns.again, 0U);
  EXPECT_TRUE(returns.are_of_a_tracker()) << returns.due << " due";
}

// Where no place comes into view again, ids that do not return are no sign.
TEST(LastingIds, AWayThatNeverComesBackTellsNothing) {
  DrivenWorld world = with_ids(false);
  world.turning = 0;
  world.half = 60;
  world.things = 400;
  EXPECT_FALSE(count_id_returns(drive(world).frames).are_of_a_tracker());
  EXPECT_FALSE(count_id_returns({}).are_of_a_tracker());
}

}  // namespace
}  // namespace hybrid
