// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, the hybrid mapping authors

#include "mrpt_plugins/mapping/path_archive.h"

#include <gtest/gtest.h>

#include <algorithm>

#include "mrpt_plugins/bridge/pose_conversions.h"

namespace hybrid {
namespace {

mrpt::poses::CPose3D plane(double x, double y, double yaw) {
  return {x, y, 0, yaw, 0, 0};
}

LaserScan scan_at(double time, const mrpt::poses::CPose3D& T_keyframe_robot) {
  LaserScan scan;
  scan.time = time;
  scan.T_keyframe_robot = to_isometry(T_keyframe_robot);
  return scan;
}

/// A keyframe that odometry puts 4 m ahead of the one before.
Keyframe bare_keyframe(double time, std::size_t robot = 0) {
  Keyframe out;
  out.robot = robot;
  out.time = time;
  out.odometry = OdometryIncrement{plane(4, 0, 0), Matrix6d::Identity(), true};
  return out;
}

/// The same with scans after each metre.
Keyframe keyframe(double time, std::size_t robot = 0) {
  Keyframe out = bare_keyframe(time, robot);
  for (int i = 3; i > 0; --i) out.scans.push_back(scan_at(time - i, plane(-i, 0, 0)));
  out.scans.push_back(scan_at(time, {}));
  return out;
}

/// The same with entries of odometry instead, on a bow to the left.
Keyframe read_keyframe(double time, std::size_t robot = 0) {
  Keyframe out = bare_keyframe(time, robot);
  for (int i = 3; i >= 0; --i) {
    out.between.push_back({time - i, to_isometry(plane(-i, i == 0 ? 0 : 1, 0))});
  }
  return out;
}

TEST(PathArchive, ThePathMeetsTheKeyframes) {
  PathArchive archive(true, true);
  Keyframe first = keyframe(0);
  first.odometry.reset();
  first.scans.erase(first.scans.begin(), first.scans.end() - 1);
  archive.add(first);
  archive.add(keyframe(4));
  archive.add(keyframe(8));
  // The map says that the robot drove 8 % less, and turned at the end.
  const Trajectory keyframes{{0, plane(0, 0, 0)}, {4, plane(3.68, 0, 0)}, {8, plane(7.36, 0, 0.4)}};
  const Trajectory path = archive.path(keyframes);
  ASSERT_EQ(path.size(), 9U);
  for (std::size_t i = 0; i < path.size(); ++i) EXPECT_EQ(path[i].time, static_cast<double>(i));
  for (std::size_t i = 0; i < 5; ++i) {
    EXPECT_NEAR(path[i].pose.x(), 0.92 * static_cast<double>(i), 1e-9);
    EXPECT_NEAR(path[i].pose.yaw(), 0, 1e-9);
  }
  for (std::size_t i = 4; i < 9; ++i) {
    EXPECT_GT(path[i].pose.x(), path[i - 1].pose.x());
    EXPECT_NEAR(path[i].pose.yaw(), 0.1 * static_cast<double>(i - 4), 1e-9);
  }
  EXPECT_EQ(path[8].pose.x(), 7.36);
  EXPECT_EQ(archive.reckoned_path(keyframes).size(), 3U);
  EXPECT_TRUE(archive.curves(keyframes).to.empty()) << "nothing of odometry";
}

TEST(PathArchive, EveryRobotHasAPathOfItsOwn) {
  PathArchive archive(true, true);
  archive.add(keyframe(0, 1));
  archive.add(keyframe(1, 0));
  archive.add(keyframe(4, 1));
  const Trajectory keyframes{{0, plane(0, 0, 0)}, {1, plane(0, 9, 0)}, {4, plane(4, 0, 0)}};
  const Trajectory path = archive.path(keyframes, 1);
  ASSERT_EQ(path.size(), 8U) << "with the scans before its first keyframe";
  EXPECT_EQ(path.front().time, -3);
  for (const TimedPose& p : path) EXPECT_NEAR(p.pose.x(), p.time, 1e-9);
  for (const TimedPose& p : archive.path(keyframes, 0)) EXPECT_EQ(p.pose.y(), 9);
}

TEST(PathArchive, WithoutOdometryThePathIsThatOfTheNextKeyframe) {
  PathArchive archive(true, true);
  Keyframe lost = keyframe(4);
  lost.odometry.reset();
  archive.add(keyframe(0));
  archive.add(lost);
  const Trajectory path = archive.path({{0, plane(0, 0, 0)}, {4, plane(10, 0, 0)}});
  ASSERT_EQ(path.size(), 8U);
  EXPECT_NEAR(path[4].pose.x(), 7, 1e-9);
}

TEST(PathArchive, TwoLasersAndAStandingClockMakeNoSecondPose) {
  PathArchive archive(true, true);
  Keyframe two = keyframe(4);
  two.scans.insert(two.scans.begin(), two.scans.front());
  two.scans.push_back(two.scans.back());
  archive.add(two);
  EXPECT_EQ(archive.path({{4, plane(0, 0, 0)}}).size(), 4U);
  PathArchive standing(true, true);
  Keyframe still = keyframe(0);
  for (LaserScan& scan : still.scans) scan.time = 0;
  standing.add(still);
  standing.add(still);
  EXPECT_EQ(standing.path({{0, plane(0, 0, 0)}, {0, plane(4, 0, 0)}}).size(), 2U);
}

TEST(PathArchive, EntriesOfOdometryAreInThePathAndInItsCurve) {
  PathArchive archive(false, true);
  archive.add(read_keyframe(0));
  archive.add(read_keyframe(4));
  archive.end(0, {{4, {}}, {5, to_isometry(plane(1, 0, 0))}, {6, to_isometry(plane(2, 0, 0))}});
  const Trajectory keyframes{{0, plane(0, 0, 0)}, {4, plane(4, 0, 0.4)}};
  const Trajectory path = archive.path(keyframes);
  ASSERT_EQ(path.size(), 7U) << "none before the first keyframe";
  for (std::size_t i = 0; i < path.size(); ++i) EXPECT_EQ(path[i].time, static_cast<double>(i));
  EXPECT_EQ(path[4].pose.yaw(), keyframes[1].pose.yaw()) << "as it is";
  EXPECT_NEAR(path[1].pose.y(), 0.69, 0.01) << "with a quarter of what is missing";
  EXPECT_NEAR(path[6].pose.x(), 4 + 2 * std::cos(0.4), 1e-9) << "after the last keyframe";
  const Trajectory reckoned{{0, plane(0, 0, 0)}, {4, plane(4, 0, 0)}};
  EXPECT_EQ(archive.reckoned_path(reckoned)[2].pose.y(), 1);
  const PathCurves curves = archive.curves(keyframes);
  ASSERT_EQ(curves.to.size(), 2U);
  EXPECT_EQ(curves.to[0].size(), 0U);
  EXPECT_EQ(curves.to[1].size(), 3U);
  ASSERT_EQ(curves.after.size(), 1U);
  ASSERT_EQ(curves.after[0].size(), 1U) << "the end of a straight line";
  EXPECT_EQ(archive.reckoned_curves(reckoned).to[1].size(), 2U) << "a bow of three lines";
}

TEST(PathArchive, OdometryBesideScansIsInThePathOnce) {
  PathArchive archive(true, true);
  Keyframe second = keyframe(4);
  for (const double t : {0.5, 1.0, 3.5, 4.0}) {
    second.between.push_back({t, to_isometry(plane(t - 4, 0, 0))});
  }
  archive.add(keyframe(0));
  archive.add(second);
  const Trajectory keyframes{{0, plane(0, 0, 0)}, {4, plane(4, 0, 0)}};
  std::vector<double> times;
  for (const TimedPose& pose : archive.path(keyframes)) {
    if (pose.time >= 0) times.push_back(pose.time);
  }
  EXPECT_EQ(times, (std::vector<double>{0, 0.5, 1, 2, 3, 3.5, 4}));
  EXPECT_EQ(archive.reckoned_path(keyframes).size(), 5U) << "with that of a scan's time";
  PathArchive matched(true, true);
  matched.add(keyframe(0), true);
  matched.add(second, true);
  EXPECT_EQ(matched.reckoned_path(keyframes).size(), 2U) << "matches are no dead reckoning";
}

TEST(PathArchive, AMapOfThePlaneHasItsPathInIt) {
  PathArchive archive(false, false);
  Keyframe second = bare_keyframe(4);
  second.between.push_back({2, to_isometry({-2, 0, 0.5, 0, 0.1, 0.1})});
  archive.add(bare_keyframe(0));
  archive.add(second);
  const Trajectory path = archive.path({{0, plane(0, 0, 0)}, {4, plane(4, 0, 0)}});
  ASSERT_EQ(path.size(), 3U);
  EXPECT_EQ(path[1].pose.z(), 0);
  EXPECT_EQ(path[1].pose.pitch(), 0);
}

TEST(PathArchive, ItsMemoryIsBounded) {
  constexpr std::size_t kMost = 100;
  PathArchive archive(true, true, kMost);
  Trajectory keyframes;
  for (std::size_t i = 0; i < 1000; ++i) {
    const double time = 4.0 * static_cast<double>(i);
    archive.add(i % 2 == 0 ? keyframe(time) : read_keyframe(time));
    keyframes.push_back({time, plane(time, 0, 0)});
  }
  const std::size_t scans = 3 * 500;
  const std::size_t rows = archive.path(keyframes).size() - 1000 - scans;
  EXPECT_LE(rows, kMost);
  EXPECT_GE(rows, kMost / 2);
}

TEST(PathArchive, CurvesHaveABoundedNumberOfPoints) {
  PathArchive archive(false, false);
  Trajectory keyframes;
  constexpr std::size_t kKeyframes = 40, kEntries = 1000;
  for (std::size_t k = 0; k < kKeyframes; ++k) {
    Keyframe next = bare_keyframe(static_cast<double>(k));
    for (std::size_t i = 1; i < kEntries; ++i) {  // to and fro by 4 cm
      const double share = static_cast<double>(i) / kEntries;
      next.between.push_back(
          {next.time - 1 + share, to_isometry(plane(4 * share - 4, i % 2 == 0 ? 0.02 : -0.02, 0))});
    }
    archive.add(next);
    keyframes.push_back({next.time, plane(4 * next.time, 0, 0)});
  }
  std::size_t points = 0;
  for (const auto& piece : archive.curves(keyframes).to) points += piece.size();
  EXPECT_LE(points, PathArchive::kMostDrawn);
}

}  // namespace
}  // namespace hybrid
