// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, the hybrid mapping authors
#include "libhybrid/scans/scan_place.h"

#include <gtest/gtest.h>

#include <random>

#include "libhybrid/scans/scan_join.h"
#include "tests/support/scan_worlds.h"

namespace hybrid {
namespace {

ScanMapper drive(const testing::FloorPlan& plan, const std::vector<SE2>& way, unsigned seed) {
  std::mt19937 random(seed);
  ScanMapper mapper;
  for (std::size_t i = 0; i < way.size(); ++i) {
    std::optional<SE2> odometry;
    if (i > 0) odometry = way[i - 1].between(way[i]);
    mapper.add(plan.scan(way[i], 181, 0.01, random), odometry);
  }
  mapper.finish();
  return mapper;
}

/// The local maps of a drive, moved by a motion.
std::vector<StoredScans> stored(const ScanMapper& mapper, const SE2& T) {
  std::vector<StoredScans> out;
  for (const LocalScans& local : local_scans(mapper.tracker())) {
    out.push_back(
        {T * mapper.pose(local.anchor), 1e-4 * Eigen::Matrix3d::Identity(), local.points});
  }
  return out;
}

/// The start that is found along a way, if it is.
std::optional<UncertainMotion> found_on(const testing::FloorPlan& plan, const std::vector<SE2>& way,
                                        ScanPlaceSearch& search, unsigned seed) {
  std::mt19937 random(seed);
  ScanMapper mapper;
  for (std::size_t i = 0; i < way.size(); ++i) {
    std::optional<SE2> odometry;
    if (i > 0) odometry = way[i - 1].between(way[i]);
    if (!mapper.add(plan.scan(way[i], 181, 0.01, random), odometry).is_keyframe) continue;
    if (const auto start = search.look(mapper)) return start;
  }
  return std::nullopt;
}

TEST(ScanPlaceSearch, FindsTheStartOfADriveAnywhere) {
  const std::vector<SE2> way = testing::way_around_ring(1, 0.1);
  const SE2 T(30, -20, 2.0);
  const ScanMapper first = drive(testing::ring(), way, 1);
  for (const std::size_t from : {40, 150, 300}) {
    SCOPED_TRACE(from);
    const std::vector<SE2> second(way.begin() + from, way.end());
    ScanPlaceSearch search(stored(first, T));
    const auto start = found_on(testing::ring(), second, search, 2);
    ASSERT_TRUE(start);
    const SE2 off = (T * way.front().between(second.front())).between(start->motion);
    EXPECT_LT(off.translation().norm(), 0.3);
    EXPECT_LT(std::abs(off.angle()), 0.05);
  }
}

TEST(ScanPlaceSearch, FindsNothingElsewhere) {
  const std::vector<SE2> way = testing::way_around_ring(1, 0.1);
  const ScanMapper first = drive(testing::ring(), way, 1);
  std::mt19937 random(3);
  std::vector<SE2> second;
  for (int i = 0; i < 200; ++i) second.emplace_back(0.1 * i - 10, 0.2, 0.0);
  ScanPlaceSearch search(stored(first, SE2()));
  EXPECT_FALSE(found_on(testing::pillars(60, random), second, search, 4));
}

TEST(ScanPlaceSearch, TwoEqualRoomsAreNotToldApart) {
  testing::FloorPlan room;
  room.add_box({-4, -3}, {4, 3});
  room.add_box({2.5, 1.8}, {4, 3});
  room.add_wall({-4, -1}, {-2.8, -1.6});
  std::vector<SE2> way;
  for (int i = 0; i < 300; ++i) {
    const double a = 2.0 * M_PI * i / 100;
    way.emplace_back(1.5 * std::cos(a), 1.5 * std::sin(a), a + 0.5 * M_PI);
  }
  const ScanMapper first = drive(room, way, 1);
  std::vector<StoredScans> both = stored(first, SE2());
  ScanPlaceSearch one(both);
  EXPECT_TRUE(found_on(room, way, one, 2));
  for (const StoredScans& scans : stored(first, SE2(50, 0, 0))) both.push_back(scans);
  ScanPlaceSearch two(both);
  EXPECT_FALSE(found_on(room, way, two, 2));
}

/// Two drives along parts of the ring, each in a frame of its own.
struct TwoDrives {
  std::vector<SE2> way = testing::way_around_ring(1, 0.1);
  std::vector<SE2> second{way.begin() + 120, way.end()};
  std::vector<StoredScans> a =
      stored(drive(testing::ring(), {way.begin(), way.begin() + 480}, 1), SE2());
  std::vector<StoredScans> b = stored(drive(testing::ring(), second, 2), SE2(30, -20, 2.0));
  SE2 T_first_second = way.front().between(second.front()) * SE2(30, -20, 2.0).inverse();
};

TEST(JoinScans, FindsHowTwoMapsLieToEachOther) {
  const TwoDrives drives;
  const ScanJoin join = join_scans(drives.a, drives.b, {});
  ASSERT_TRUE(join.is_found()) << join.why;
  EXPECT_GE(join.accepted, 3U);
  ASSERT_EQ(join.first.size(), drives.a.size());
  ASSERT_EQ(join.second.size(), drives.b.size());
  for (std::size_t k = 0; k < drives.b.size(); ++k) {
    const SE2 truth = drives.T_first_second * drives.b[k].T_map_anchor;
    const SE2 off = truth.between(join.second[k].T_map_anchor);
    EXPECT_LT(off.translation().norm(), 0.3) << k;
    EXPECT_LT(std::abs(off.angle()), 0.03) << k;
    EXPECT_GT(join.second[k].covariance.trace(), 1e-6);
  }
}

TEST(JoinScans, OtherBuildingsAreNotJoined) {
  const TwoDrives drives;
  std::mt19937 random(3);
  std::vector<SE2> way;
  for (int i = 0; i < 200; ++i) way.emplace_back(0.1 * i - 10, 0.2, 0.0);
  const ScanJoin join =
      join_scans(drives.a, stored(drive(testing::pillars(60, random), way, 4), {}), {});
  EXPECT_FALSE(join.is_found());
  EXPECT_NE(join.why.find("stretch"), std::string::npos) << join.why;
  EXPECT_FALSE(join_scans(drives.a, {}, {}).is_found());
  EXPECT_FALSE(join_scans({}, drives.b, {}).is_found());
}

TEST(JoinScans, OneOfTwoEqualPlacesIsNotTaken) {
  const TwoDrives drives;
  std::vector<StoredScans> both = drives.a;
  for (StoredScans scans : drives.a) {
    scans.T_map_anchor = SE2(100, 0, 0) * scans.T_map_anchor;
    both.push_back(scans);
  }
  const ScanJoin join = join_scans(both, drives.b, {});
  EXPECT_FALSE(join.is_found());
  EXPECT_NE(join.why.find("as well at"), std::string::npos) << join.why;
}

TEST(ScanPlaceSearch, NothingStoredIsNoFault) {
  ScanPlaceSearch none({});
  ScanPlaceSearch empty({StoredScans()});
  const std::vector<SE2> way = testing::way_around_ring(1, 0.2);
  EXPECT_FALSE(found_on(testing::ring(), way, none, 1));
  EXPECT_FALSE(found_on(testing::ring(), way, empty, 1));
}

}  // namespace
}  // namespace hybrid
