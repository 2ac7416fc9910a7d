// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, the hybrid mapping authors

#include "mrpt_plugins/mapping/scan_archive.h"

#include <gtest/gtest.h>

#include <algorithm>

#include "mrpt_plugins/bridge/pose_conversions.h"

namespace hybrid {
namespace {

mrpt::poses::CPose3D plane(double x, double y, double yaw) {
  return {x, y, 0, yaw, 0, 0};
}

LaserScan scan_at(double time, const mrpt::poses::CPose3D& T_keyframe_robot,
                  std::size_t rays = 10) {
  LaserScan scan;
  scan.time = time;
  scan.ranges.assign(rays, 1.0F);
  scan.T_keyframe_robot = to_isometry(T_keyframe_robot);
  return scan;
}

/// A keyframe that odometry puts 4 m ahead of the one before, with scans after each of them.
Keyframe keyframe(double time, std::size_t robot = 0) {
  Keyframe out;
  out.robot = robot;
  out.time = time;
  out.odometry = OdometryIncrement{plane(4, 0, 0), Matrix6d::Identity(), true};
  for (int i = 3; i > 0; --i) out.scans.push_back(scan_at(time - i, plane(-i, 0, 0)));
  out.scans.push_back(scan_at(time, {}));
  return out;
}

TEST(ScanArchive, ThePathMeetsTheKeyframes) {
  ScanArchive archive;
  Keyframe first = keyframe(0);
  first.odometry.reset();
  first.scans.erase(first.scans.begin(), first.scans.end() - 1);
  archive.add(0, first);
  archive.add(1, keyframe(4));
  archive.add(2, keyframe(8));
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
}

TEST(ScanArchive, EveryRobotHasAPathOfItsOwn) {
  ScanArchive archive;
  archive.add(0, keyframe(0, 1));
  archive.add(1, keyframe(1, 0));
  archive.add(2, keyframe(4, 1));
  const Trajectory keyframes{{0, plane(0, 0, 0)}, {1, plane(0, 9, 0)}, {4, plane(4, 0, 0)}};
  const Trajectory path = archive.path(keyframes, 1);
  ASSERT_EQ(path.size(), 8U) << "with the scans before its first keyframe";
  EXPECT_EQ(path.front().time, -3);
  for (const TimedPose& p : path) EXPECT_NEAR(p.pose.x(), p.time, 1e-9);
  for (const TimedPose& p : archive.path(keyframes, 0)) EXPECT_EQ(p.pose.y(), 9);
  EXPECT_EQ(archive.robot_of(1), 0U);
}

TEST(ScanArchive, WithoutOdometryThePathIsThatOfTheNextKeyframe) {
  ScanArchive archive;
  Keyframe lost = keyframe(4);
  lost.odometry.reset();
  archive.add(0, keyframe(0));
  archive.add(1, lost);
  const Trajectory path = archive.path({{0, plane(0, 0, 0)}, {4, plane(10, 0, 0)}});
  ASSERT_EQ(path.size(), 8U);
  EXPECT_NEAR(path[4].pose.x(), 7, 1e-9);
}

TEST(ScanArchive, TwoLasersAndAStandingClockMakeNoSecondPose) {
  ScanArchive archive;
  Keyframe two = keyframe(4);
  two.scans.insert(two.scans.begin(), two.scans.front());
  two.scans.push_back(two.scans.back());
  archive.add(0, two);
  EXPECT_EQ(archive.path({{4, plane(0, 0, 0)}}).size(), 4U);
  ScanArchive standing;
  Keyframe still = keyframe(0);
  for (LaserScan& scan : still.scans) scan.time = 0;
  standing.add(0, still);
  standing.add(1, still);
  EXPECT_EQ(standing.path({{0, plane(0, 0, 0)}, {0, plane(4, 0, 0)}}).size(), 2U);
}

TEST(ScanArchive, MemoryIsBoundedAndThePathWhole) {
  constexpr std::size_t kBudget = 4000;  // bytes: a hundred scans
  ScanArchive archive(kBudget);
  Trajectory keyframes;
  const auto kept = [&](bool own) {
    return std::count_if(archive.entries().begin(), archive.entries().end(),
                         [&](const auto& e) { return e.is_own == own && !e.scan.ranges.empty(); });
  };
  for (std::size_t i = 0; i < 1000; ++i) {
    archive.add(i, keyframe(4.0 * static_cast<double>(i)));
    keyframes.push_back({4.0 * static_cast<double>(i), plane(4.0 * static_cast<double>(i), 0, 0)});
    EXPECT_LE(40 * (kept(true) + kept(false)), static_cast<std::ptrdiff_t>(kBudget));
    if (i == 40) {
      EXPECT_EQ(kept(true), 41) << "those of keyframes go last";
    }
  }
  EXPECT_GE(kept(true), 25);
  EXPECT_EQ(archive.given_up() + static_cast<std::size_t>(kept(true) + kept(false)), 4000U);
  EXPECT_EQ(archive.path(keyframes).size(), 4000U);
}

}  // namespace
}  // namespace hybrid
