// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, the hybrid mapping authors

#include <gtest/gtest.h>

#include <cmath>
#include <limits>
#include <random>

#include "libhybrid/scans/scan_mapper.h"
#include "tests/support/scan_worlds.h"

namespace hybrid {
namespace {

constexpr double kNaN = std::numeric_limits<double>::quiet_NaN();

/// A way, what a laser sees on it, and odometry that tells of the way with small errors.
struct Drive {
  Drive(const testing::FloorPlan& plan, std::vector<SE2> along, unsigned seed = 1)
      : way(std::move(along)) {
    std::mt19937 random(seed);
    std::normal_distribution<double> noise;
    for (std::size_t i = 0; i < way.size(); ++i) {
      scans.push_back(plan.scan(way[i], 181, 0.01, random));
      if (i == 0) continue;
      const SE2 error(0.01 * noise(random), 0.005 * noise(random), 0.01 * noise(random));
      odometry.push_back(way[i - 1].between(way[i]) * error);
    }
  }

  std::vector<SE2> way;
  std::vector<LaserScan> scans;
  std::vector<SE2> odometry;  // to the next scan
};

Drive ring_drive(int rounds = 1, double step = 0.1) {
  return Drive(testing::ring(), testing::way_around_ring(rounds, step));
}

ScanMapper mapped(const Drive& drive) {
  ScanMapper mapper;
  for (std::size_t i = 0; i < drive.scans.size(); ++i) {
    mapper.add(drive.scans[i], i > 0 ? std::optional(drive.odometry[i - 1]) : std::nullopt);
  }
  mapper.finish();
  return mapper;
}

/// Of distances from the truth, in the frame of the first pose [m].
struct Errors {
  double mean = 0.0, most = 0.0;
};

Errors errors_of(const std::vector<SE2>& path, const std::vector<SE2>& way) {
  EXPECT_EQ(path.size(), way.size());
  Errors out;
  for (std::size_t i = 0; i < path.size(); ++i) {
    const Eigen::Vector2d truth = way.front().between(way[i]).translation();
    const double error = (truth - path[i].translation()).norm();
    out.mean += error / double(path.size());
    out.most = std::max(out.most, error);
  }
  return out;
}

bool all_finite(const ScanMapper& mapper) {
  for (const SE2& pose : mapper.path()) {
    if (!std::isfinite(pose.x()) || !std::isfinite(pose.y()) || !std::isfinite(pose.angle())) {
      return false;
    }
  }
  return true;
}

TEST(BadScans, NumbersThatAreNoneDoNotSpreadFromOneScan) {
  const double infinity = std::numeric_limits<double>::infinity();
  for (const double bad : {kNaN, infinity, -infinity, 1e300}) {
    SCOPED_TRACE(bad);
    Drive drive = ring_drive();
    for (float& range : drive.scans[50].ranges) range = static_cast<float>(bad);
    drive.scans[80].first_angle = bad;
    drive.scans[110].angle_step = bad;
    drive.scans[140].max_range = bad;
    drive.scans[170].T_robot_sensor.translation().x() = bad;
    drive.scans[200].T_robot_sensor.linear()(0, 1) = bad;
    const ScanMapper mapper = mapped(drive);
    ASSERT_TRUE(all_finite(mapper));
    EXPECT_LT(errors_of(mapper.path(), drive.way).most, 0.3);
  }
}

TEST(BadScans, OdometryThatIsNoNumberIsNone) {
  const double infinity = std::numeric_limits<double>::infinity();
  for (const double bad : {kNaN, infinity, -infinity, 1e300}) {
    SCOPED_TRACE(bad);
    Drive drive = ring_drive();
    drive.odometry[60] = SE2(bad, 0.0, 0.0);
    drive.odometry[120] = SE2(0.1, bad, 0.0);
    if (std::abs(bad) > 1e301 || std::isnan(bad)) drive.odometry[180] = SE2(0.1, 0.0, bad);
    const ScanMapper mapper = mapped(drive);
    ASSERT_TRUE(all_finite(mapper));
    EXPECT_LT(errors_of(mapper.path(), drive.way).most, 0.3);
  }
}

TEST(BadScans, OneRayFollowsOdometry) {
  Drive drive = ring_drive();
  for (LaserScan& scan : drive.scans) scan.ranges = {scan.ranges[90]};
  const ScanMapper mapper = mapped(drive);
  SE2 pose;
  for (const SE2& motion : drive.odometry) pose = pose * motion;
  EXPECT_NEAR((mapper.path().back().translation() - pose.translation()).norm(), 0.0, 1e-3);
  EXPECT_TRUE(mapper.closures().empty());
}

TEST(BadScans, AnHourAtOnePlaceIsTwoKeyframes) {
  Drive drive(testing::ring(), std::vector<SE2>(20, SE2(-1, -1, 0.2)));
  std::mt19937 random(3);
  std::normal_distribution<double> noise;
  for (const bool has_odometry : {true, false}) {
    ScanMapper mapper;
    for (int i = 0; i < 36000; ++i) {
      std::optional<SE2> odometry;
      if (has_odometry) odometry = SE2(2e-3 * noise(random), 2e-3 * noise(random), 0.0);
      mapper.add(drive.scans[i % 20], odometry);
    }
    mapper.finish();
    EXPECT_LE(mapper.tracker().keyframes().size(), 2u);
    EXPECT_EQ(mapper.path().size(), 36000u);
    EXPECT_LT(mapper.path().back().translation().norm(), 0.02);
  }
}

TEST(BadScans, SixMinutesOfKeyframesAtOnePlaceAreOnePlace) {
  const Drive drive(testing::ring(), std::vector<SE2>(20, SE2(-1, -1, 0.2)));
  ScanMapper mapper;
  for (int i = 0; i < 1800; ++i) {
    mapper.add(scan_points(drive.scans[i % 20]), std::nullopt, KeyframeRule::kAlways);
  }
  mapper.finish();
  EXPECT_LT(mapper.path().back().translation().norm(), 0.05);
  EXPECT_LT(mapper.closures().size(), 100u);
}

TEST(BadScans, AHandBeforeTheLaserIsForgotten) {
  Drive drive = ring_drive();
  std::mt19937 random(5);
  std::uniform_real_distribution<float> near(0.1F, 1.0F);
  for (const std::size_t i : {60, 200, 201, 330, 331, 332}) {
    for (float& range : drive.scans[i].ranges) range = near(random);
  }
  const ScanMapper mapper = mapped(drive);
  EXPECT_LT(errors_of(mapper.path(), drive.way).mean, 0.05);
  const SE2 truth = drive.way.front().between(drive.way.back());
  EXPECT_LT((mapper.path().back().translation() - truth.translation()).norm(), 0.15);
}

TEST(BadScans, ACorridorWithoutAnEndIsAsLongAsOdometrySays) {
  testing::FloorPlan plan;
  plan.add_wall({-1000, -1}, {1000, -1});
  plan.add_wall({-1000, 1}, {1000, 1});
  std::vector<SE2> way;
  for (int i = 0; i < 1000; ++i) way.emplace_back(0.1 * i, 0.0, 0.0);
  const Drive drive(plan, way);
  const ScanMapper mapper = mapped(drive);
  EXPECT_NEAR(mapper.path().back().x(), 99.9, 1.5);
  EXPECT_LT(mapper.closures().size(), 200u);
}

TEST(BadScans, OdometryOfAnotherRobotDoesNotLeadAwayWhereScansTell) {
  std::vector<SE2> way;
  for (int i = 0; i < 600; ++i) {
    const double a = 2.0 * M_PI * i / 200;
    way.emplace_back(1.8 * std::cos(a), 1.8 * std::sin(a), a + 0.5 * M_PI);
  }
  Drive drive(testing::furnished_room(), way);
  for (SE2& motion : drive.odometry) motion = motion.inverse();
  const ScanMapper mapper = mapped(drive);
  EXPECT_LT(errors_of(mapper.path(), drive.way).mean, 0.05);
  EXPECT_GT(mapper.tracker().odometry_noise().translation_scale(), 5.0);
}

}  // namespace
}  // namespace hybrid
