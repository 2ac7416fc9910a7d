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

TEST(ScanArchive, KnowsTheRobotOfAKeyframe) {
  ScanArchive archive;
  archive.add(0, keyframe(0, 1));
  archive.add(1, keyframe(1, 0));
  EXPECT_EQ(archive.robot_of(0), 1U);
  EXPECT_EQ(archive.robot_of(1), 0U);
}

TEST(ScanArchive, MemoryIsBounded) {
  constexpr std::size_t kBudget = 4000;  // bytes: a hundred scans
  ScanArchive archive(kBudget);
  const auto kept = [&](bool own) {
    return std::count_if(archive.entries().begin(), archive.entries().end(),
                         [&](const auto& e) { return e.is_own == own && !e.scan.ranges.empty(); });
  };
  for (std::size_t i = 0; i < 1000; ++i) {
    archive.add(i, keyframe(4.0 * static_cast<double>(i)));
    EXPECT_LE(40 * (kept(true) + kept(false)), static_cast<std::ptrdiff_t>(kBudget));
    if (i == 40) {
      EXPECT_EQ(kept(true), 41) << "those of keyframes go last";
    }
  }
  EXPECT_GE(kept(true), 25);
  EXPECT_EQ(archive.given_up() + static_cast<std::size_t>(kept(true) + kept(false)), 4000U);
}

}  // namespace
}  // namespace hybrid
