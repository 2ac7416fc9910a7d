// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, the hybrid mapping authors
#include "libhybrid/scans/scan_place.h"

#include <gtest/gtest.h>

#include <Eigen/Eigenvalues>
#include <cmath>
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
        {{T * mapper.pose(local.anchor), 1e-4 * Eigen::Matrix3d::Identity()}, local.points});
  }
  return out;
}

/// The start that is found along a way, if it is; `mapper` has followed the drive up to there.
std::optional<UncertainMotion> found_on(const testing::FloorPlan& plan, const std::vector<SE2>& way,
                                        ScanPlaceSearch& search, unsigned seed,
                                        ScanMapper& mapper) {
  std::mt19937 random(seed);
  for (std::size_t i = 0; i < way.size(); ++i) {
    std::optional<SE2> odometry;
    if (i > 0) odometry = way[i - 1].between(way[i]);
    if (!mapper.add(plan.scan(way[i], 181, 0.01, random), odometry).is_keyframe) continue;
    if (const auto start = search.look(mapper)) return start;
  }
  return std::nullopt;
}

std::optional<UncertainMotion> found_on(const testing::FloorPlan& plan, const std::vector<SE2>& way,
                                        ScanPlaceSearch& search, unsigned seed) {
  ScanMapper mapper;
  return found_on(plan, way, search, seed, mapper);
}

// A drive is recognised where it is; its start is known as well as the way from there.
TEST(ScanPlaceSearch, TheStartIsNotKnownBetterThanTheWayToIt) {
  const std::vector<SE2> way = testing::way_around_ring(1, 0.1);
  const ScanMapper first = drive(testing::ring(), way, 1);
  ScanPlaceSearch search(stored(first, SE2()));
  ScanMapper mapper;
  const auto start = found_on(testing::ring(), way, search, 2, mapper);
  ASSERT_TRUE(start);
  const std::size_t last = mapper.tracker().keyframes().size() - 1;
  const Eigen::Matrix3d beyond = start->covariance - mapper.relation(last, 0).covariance;
  EXPECT_GT(beyond.selfadjointView<Eigen::Lower>().eigenvalues().minCoeff(), 0.0);
  EXPECT_LT(std::sqrt(start->covariance(0, 0)), 0.1);
  EXPECT_LT(std::sqrt(start->covariance(1, 1)), 0.1);
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

/// A corridor along x, 2 m wide, with niches at places of its own.
testing::FloorPlan corridor(double length, unsigned seed) {
  std::mt19937 random(seed);
  std::uniform_real_distribution<double> gap(2.0, 5.0), size(0.5, 1.4), depth(0.2, 0.5);
  testing::FloorPlan plan;
  for (const double side : {-1.0, 1.0}) {
    double from = -2.0;
    for (double x = gap(random) - 2.0; x < length - 2.0; x += gap(random)) {
      const double to = x + size(random), y = side * (1.0 + depth(random));
      plan.add_wall({from, side}, {x, side});
      plan.add_wall({x, side}, {x, y});
      plan.add_wall({x, y}, {to, y});
      plan.add_wall({to, y}, {to, side});
      from = x = to;
    }
    plan.add_wall({from, side}, {length, side});
  }
  plan.add_wall({-2, -1}, {-2, 1});
  plan.add_wall({length, -1}, {length, 1});
  return plan;
}

/// Along a corridor and back.
std::vector<SE2> way_along(double length) {
  std::vector<SE2> way;
  for (double x = 0; x < length - 2; x += 0.1) way.emplace_back(x, 0.1, 0.0);
  for (double a = 0; a < M_PI; a += 0.15) way.emplace_back(length - 2, 0.1, a);
  for (double x = length - 2; x > 0; x -= 0.1) way.emplace_back(x, 0.1, M_PI);
  return way;
}

TEST(ScanPlaceSearch, ACorridorIsNotTakenForThatOfAnotherBuilding) {
  const ScanMapper first = drive(corridor(40, 1), way_along(40), 1);
  for (unsigned other = 2; other < 5; ++other) {
    ScanPlaceSearch search(stored(first, SE2()));
    EXPECT_FALSE(found_on(corridor(30, other), way_along(30), search, 10 + other)) << other;
  }
  ScanPlaceSearch same(stored(first, SE2()));
  const auto start = found_on(corridor(40, 1), way_along(40), same, 2);
  ASSERT_TRUE(start);
  EXPECT_LT(start->motion.translation().norm(), 0.3);
}

/// Rooms of one kind in a row, with doors to a corridor.
testing::FloorPlan equal_rooms(int count) {
  testing::FloorPlan plan;
  const double right = 4.0 + 6.0 * count;
  plan.add_wall({-1, -1}, {right, -1});
  plan.add_wall({-1, -1}, {-1, 1});
  plan.add_wall({right, -1}, {right, 1});
  double x = -1;
  for (int k = 0; k < count; ++k) {
    const double c = 4.0 + 6.0 * k;
    plan.add_wall({x, 1}, {c - 0.5, 1});
    x = c + 0.5;
    plan.add_wall({c - 2.5, 1}, {c - 2.5, 6});
    plan.add_wall({c - 2.5, 6}, {c + 2.5, 6});
    plan.add_wall({c + 2.5, 6}, {c + 2.5, 1});
    plan.add_box({c + 1, 4.2}, {c + 2, 5.2});
  }
  plan.add_wall({x, 1}, {right, 1});
  return plan;
}

/// From one corner to the next, turning there.
std::vector<SE2> way_by(const std::vector<Eigen::Vector2d>& corners) {
  std::vector<SE2> way;
  double heading = 0;
  for (std::size_t i = 0; i + 1 < corners.size(); ++i) {
    const Eigen::Vector2d leg = corners[i + 1] - corners[i];
    const SO2 to(std::atan2(leg.y(), leg.x()));
    const double turn = (SO2(heading).inverse() * to).angle();
    for (int k = 1; k <= 20; ++k) way.emplace_back(corners[i], SO2(heading + turn * k / 20));
    heading += turn;
    for (double s = 0; s < leg.norm(); s += 0.1) {
      way.emplace_back(corners[i] + s * leg.normalized(), to);
    }
  }
  return way;
}

TEST(ScanPlaceSearch, ARoomIsNotTakenForOneThatLooksLikeIt) {
  const testing::FloorPlan plan = equal_rooms(4);
  const ScanMapper first =
      drive(plan, way_by({{0, 0}, {4, 0}, {4, 3.2}, {2.8, 4}, {4, 3.2}, {4, 0}, {0, 0}}), 1);
  for (const double c : {10.0, 16.0}) {
    ScanPlaceSearch search(stored(first, SE2()));
    const std::vector<SE2> way = way_by({{c - 1.5, 2.5},
                                         {c + 0.3, 2.5},
                                         {c + 0.3, 3.6},
                                         {c - 1.6, 4.6},
                                         {c - 1.6, 2},
                                         {c, 3},
                                         {c - 1.4, 4.4},
                                         {c, 2.2},
                                         {c, 0.2},
                                         {c + 3, 0}});
    EXPECT_FALSE(found_on(plan, way, search, 2)) << c;
  }
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
  ScanPlaceOptions options;
  options.votes = 1;  // the map is of one room, and so is the drive
  ScanPlaceSearch one(both, options);
  EXPECT_TRUE(found_on(room, way, one, 2));
  for (const StoredScans& scans : stored(first, SE2(50, 0, 0))) both.push_back(scans);
  ScanPlaceSearch two(both, options);
  EXPECT_FALSE(found_on(room, way, two, 2));
  const Eigen::Matrix3d covariance = Eigen::Vector3d(1, 1, 0.17).cwiseAbs2().asDiagonal();
  options.start = {SE2(50.8, -0.7, 0.1), covariance};
  ScanPlaceSearch second(both, options);
  const auto start = found_on(room, way, second, 2);
  ASSERT_TRUE(start);
  EXPECT_LT(SE2(50, 0, 0).between(start->motion).translation().norm(), 0.3);
  options.start->motion = SE2(25, 0, 0);
  ScanPlaceSearch neither(both, options);
  EXPECT_FALSE(found_on(room, way, neither, 2));
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
  ASSERT_EQ(join.anchors.size(), drives.a.size() + drives.b.size());
  for (std::size_t k = 0; k < drives.b.size(); ++k) {
    const SE2 truth = drives.T_first_second * drives.b[k].T_map_anchor.motion;
    const UncertainMotion& found = join.anchors[drives.a.size() + k];
    const SE2 off = truth.between(found.motion);
    EXPECT_LT(off.translation().norm(), 0.3) << k;
    EXPECT_LT(std::abs(off.angle()), 0.03) << k;
    EXPECT_GT(found.covariance.trace(), 1e-6);
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

TEST(JoinScans, MapsThatShareLessThanTellsThemApartAreNotJoinedWrongly) {
  const testing::FloorPlan plan = corridor(60, 1);
  std::vector<SE2> way = way_along(60);
  way.resize(580);  // there, not back
  const std::vector<SE2> second(way.begin() + 265, way.end());
  const ScanJoin join = join_scans(stored(drive(plan, {way.begin(), way.begin() + 315}, 1), SE2()),
                                   stored(drive(plan, second, 2), SE2()), {});
  if (!join.is_found()) return;
  const SE2 off = way.front().between(second.front()).between(join.T_first_second.motion);
  EXPECT_LT(off.translation().norm(), 0.5);
}

TEST(JoinScans, OneOfTwoEqualPlacesIsNotTaken) {
  const TwoDrives drives;
  std::vector<StoredScans> both = drives.a;
  for (StoredScans scans : drives.a) {
    scans.T_map_anchor.motion = SE2(100, 0, 0) * scans.T_map_anchor.motion;
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
