// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, the hybrid mapping authors
#include "libhybrid/uncertainty/lasting_ids.h"

#include <gtest/gtest.h>

#include <map>
#include <utility>

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

/// Gives a second thing the id of another.
void share(std::int64_t id, std::int64_t with, std::vector<MovedSightings>& frames) {
  for (MovedSightings& frame : frames) {
    for (auto& seen : frame.ids) {
      if (seen == with) seen = id;
    }
  }
}

/// Two ids that are seen together ten times, far from each other.
std::pair<std::int64_t, std::int64_t> far_apart(const std::vector<MovedSightings>& frames) {
  std::map<std::pair<std::int64_t, std::int64_t>, int> together;
  for (const MovedSightings& frame : frames) {
    for (std::size_t a = 0; a < frame.ids.size(); ++a) {
      for (std::size_t b = 0; b < frame.ids.size(); ++b) {
        if (!frame.ids[a] || !frame.ids[b]) continue;
        const Eigen::VectorXd &p = frame.sightings.seen[a].z, &q = frame.sightings.seen[b].z;
        const double apart = std::hypot(p[0] * std::cos(p[1]) - q[0] * std::cos(q[1]),
                                        p[0] * std::sin(p[1]) - q[0] * std::sin(q[1]));
        if (apart < 6) continue;
        const std::pair pair(*frame.ids[a], *frame.ids[b]);
        if (++together[pair] == 10) return pair;
      }
    }
  }
  return {-1, -1};
}

TEST(SharedIds, AnIdThatIsSeenHereAndSoonAfterThereIsOfTwoThings) {
  for (unsigned seed = 1; seed <= 3; ++seed) {
    DrivenWorld world = with_ids(false);
    world.seed = seed;
    DrivenLog log = drive(world);
    EXPECT_TRUE(shared_ids(log.frames).empty()) << seed;
    const auto [id, other] = far_apart(log.frames);
    ASSERT_GE(id, 0);
    share(id, other, log.frames);
    const std::vector<SharedId> found = shared_ids(log.frames);
    ASSERT_EQ(found.size(), 1U) << seed;
    EXPECT_EQ(found[0].id, id);
    EXPECT_GT(found[0].apart, 3);
  }
}

// Loops move all places where odometry is worse than it says, but after a long way.
TEST(SharedIds, OdometryThatIsWorseThanStatedIsNoSign) {
  DrivenWorld world = with_ids(false);
  world.odometry_angle = 0.02;
  EXPECT_TRUE(shared_ids(drive(world).frames).empty());
  EXPECT_TRUE(shared_ids(drive(with_ids(true)).frames).empty());
  EXPECT_TRUE(shared_ids({}).empty());
}

}  // namespace
}  // namespace hybrid
