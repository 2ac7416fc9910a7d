// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, the hybrid mapping authors

#include "mrpt_plugins/input/scans.h"

#include <gtest/gtest.h>
#include <mrpt/obs/CObservation2DRangeScan.h>

#include <cmath>
#include <limits>
#include <random>
#include <vector>

#include "mrpt_plugins/bridge/pose_conversions.h"
#include "mrpt_plugins/input/keyframe_source.h"
#include "mrpt_plugins/input/log_contents.h"
#include "tests/mrpt_plugins/input/log_files.h"
#include "tests/support/scan_worlds.h"

namespace hybrid {
namespace {

using mrpt::obs::CObservation2DRangeScan;

CObservation2DRangeScan::Ptr scan(double time, std::size_t rays = 5) {
  auto o = CObservation2DRangeScan::Create();
  o->timestamp = time < 0 ? INVALID_TIMESTAMP : mrpt::Clock::fromDouble(time);
  o->aperture = static_cast<float>(M_PI);
  o->maxRange = 10;
  o->resizeScanAndAssign(rays, 2.0F, true);
  return o;
}

/// Where ray i of a scan ends, in the frame of the robot.
Eigen::Vector3d end_of(const LaserScan& scan, std::size_t i) {
  const double angle = scan.first_angle + static_cast<double>(i) * scan.angle_step;
  const double range = static_cast<double>(scan.ranges[i]);
  return scan.T_robot_sensor * Eigen::Vector3d(range * std::cos(angle), range * std::sin(angle), 0);
}

TEST(Scans, RaysAreWhereMrptPutsThem) {
  DropReport report;
  const auto o = scan(1, 7);
  o->aperture = 4.0F;
  o->sensorPose = {0.3, -0.2, 0.5, 0.4, 0.1, -0.2};
  for (const bool counter_clockwise : {true, false}) {
    for (const bool upside_down : {true, false}) {
      o->rightToLeft = counter_clockwise;
      if (upside_down) o->sensorPose = o->sensorPose + mrpt::poses::CPose3D(0, 0, 0, 0, 0, M_PI);
      for (std::size_t i = 0; i < 7; ++i) o->setScanRange(i, 1.0F + static_cast<float>(i));
      const auto read = scan_in(*o, {}, report);
      ASSERT_TRUE(read);
      for (std::size_t i = 0; i < 7; ++i) {
        const double angle = static_cast<double>(o->getScanAngle(i));
        const auto p =
            o->sensorPose + mrpt::poses::CPose3D::FromTranslation((1.0 + i) * std::cos(angle),
                                                                  (1.0 + i) * std::sin(angle), 0);
        EXPECT_NEAR((end_of(*read, i) - point_of(p)).norm(), 0, 1e-5) << i;
      }
    }
  }
  EXPECT_TRUE(report.empty());
}

TEST(Scans, RaysWithoutAReturnAreNan) {
  const auto o = scan(1, 8);
  o->setScanRangeValidity(0, false);
  o->setScanRange(1, 0);
  o->setScanRange(2, 10);
  o->setScanRange(3, 81.9F);
  o->setScanRange(4, -1);
  o->setScanRange(5, std::numeric_limits<float>::quiet_NaN());
  o->setScanRange(6, std::numeric_limits<float>::infinity());
  DropReport report;
  auto read = scan_in(*o, {}, report);
  ASSERT_TRUE(read);
  for (std::size_t i = 0; i < 7; ++i) EXPECT_TRUE(std::isnan(read->ranges[i])) << i;
  EXPECT_EQ(read->ranges[7], 2);
  EXPECT_EQ(read->max_range, 10);
  EXPECT_TRUE(std::isnan(scan_in(*o, {1.5, 0}, report)->ranges[7])) << "beyond the chosen limit";
  o->maxRange = std::numeric_limits<float>::quiet_NaN();
  read = scan_in(*o, {50, 0}, report);
  EXPECT_EQ(read->max_range, 50);
  EXPECT_EQ(read->ranges[2], 10);
  EXPECT_TRUE(report.empty());
}

TEST(Scans, AbsurdScansAreDroppedAndCounted) {
  const float nan = std::numeric_limits<float>::quiet_NaN();
  const auto reason_of = [](const auto& spoil) {
    const auto o = scan(1);
    spoil(*o);
    DropReport report;
    EXPECT_FALSE(scan_in(*o, {}, report));
    return report.size() == 1 ? report.begin()->first : "";
  };
  EXPECT_EQ(reason_of([](auto& o) { o.resizeScan(0); }), "scan dropped: no rays");
  for (const float angle : {0.0F, -1.0F, 7.0F, nan}) {
    EXPECT_EQ(reason_of([&](auto& o) { o.aperture = angle; }),
              "scan dropped: field of view absurd");
  }
  EXPECT_EQ(reason_of([](auto& o) { o.deltaPitch = 0.1; }),
            "scan dropped: the sensor tilts while it sweeps");
  EXPECT_EQ(reason_of([&](auto& o) { o.sensorPose.x(nan); }),
            "scan dropped: sensor pose not finite");
  EXPECT_EQ(reason_of([](auto& o) { o.sensorPose.x(1e4); }), "scan dropped: sensor pose absurd");
  for (const double tilt : {0.3, M_PI_2, M_PI - 0.3}) {
    EXPECT_EQ(reason_of([&](auto& o) { o.sensorPose = {0, 0, 0, 1, 0, tilt}; }),
              "scan dropped: the laser is not level");
    EXPECT_EQ(reason_of([&](auto& o) { o.sensorPose = {0, 0, 0, 1, tilt, 0}; }),
              "scan dropped: the laser is not level");
  }
}

TEST(Scans, TheFieldOfViewCanBeChosen) {
  DropReport report;
  const auto o = scan(1, 3);
  const auto read = scan_in(*o, {1000, M_PI_2}, report);
  EXPECT_NEAR(read->first_angle, -M_PI_4, 1e-12);
  EXPECT_NEAR(read->angle_step, M_PI_4, 1e-12);
  const auto single = scan_in(*scan(1, 1), {}, report);
  EXPECT_EQ(single->first_angle, 0);
  EXPECT_EQ(single->angle_step, 0);
}

std::vector<Keyframe> keyframes_of(const Objects& objects, const SourceOptions& options,
                                   DropReport* dropped = nullptr, DropReport* warnings = nullptr) {
  const TemporaryFile log("scans.rawlog");
  write_log(log.path(), objects);
  KeyframeSource source(log.path(), options);
  std::vector<Keyframe> out;
  while (auto keyframe = source.next()) out.push_back(std::move(*keyframe));
  EXPECT_EQ(source.status(), LogStatus::kComplete);
  if (dropped != nullptr) *dropped = source.dropped();
  if (warnings != nullptr) *warnings = source.warnings();
  return out;
}

std::size_t count_scans(const std::vector<Keyframe>& keyframes) {
  std::size_t count = 0;
  for (const Keyframe& keyframe : keyframes) count += keyframe.scans.size();
  return count;
}

/// Ten frames a metre apart on a left turn, with or without time stamps.
Objects pairs(bool with_times) {
  Objects objects;
  for (int i = 0; i < 10; ++i) {
    if (i > 0) objects.push_back(motion_2d({1, 0, 0.1}, 0.01));
    objects.push_back(frame({scan(with_times ? i : -1.0), scan(with_times ? i : -1.0, 9)}));
  }
  return objects;
}

TEST(Scans, EveryScanArrivesAtItsPlaceInPairs) {
  SourceOptions options;
  options.keyframes.min_distance = 2.5;
  for (const bool with_times : {true, false}) {
    const auto keyframes = keyframes_of(pairs(with_times), options);
    EXPECT_EQ(count_scans(keyframes), 20U);
    ASSERT_EQ(keyframes.size(), 4U);
    ASSERT_EQ(keyframes[1].scans.size(), 6U);
    const LaserScan& first = keyframes[1].scans.front();
    EXPECT_EQ(first.time, 1);
    EXPECT_EQ(first.ranges.size(), 5U);
    const auto step = to_isometry(mrpt::poses::CPose3D(mrpt::poses::CPose2D(1, 0, 0.1)));
    EXPECT_TRUE((first.T_keyframe_robot * step * step).isApprox(Eigen::Isometry3d::Identity()));
    const LaserScan& last = keyframes[1].scans.back();
    EXPECT_EQ(last.time, keyframes[1].time);
    EXPECT_EQ(last.ranges.size(), 9U);
    EXPECT_TRUE(last.T_keyframe_robot.matrix().isIdentity(0));
  }
}

TEST(Scans, EveryScanArrivesInLogsOfObservations) {
  Objects objects, without_odometry;
  for (int i = 0; i < 10; ++i) {
    objects.push_back(absolute_odometry(i, {0.5 * i, 0, 0}));
    objects.push_back(scan(i + 0.5));
    without_odometry.push_back(scan(i));
  }
  SourceOptions options;
  options.keyframes.min_distance = 1.9;
  DropReport dropped;
  auto keyframes = keyframes_of(objects, options, &dropped);
  EXPECT_EQ(count_scans(keyframes), 9U) << "those after the last keyframe have no place";
  EXPECT_TRUE(dropped.empty());
  ASSERT_EQ(keyframes.size(), 3U);
  EXPECT_NEAR(keyframes[1].scans[0].T_keyframe_robot.translation().x(), -1.5, 1e-9);
  EXPECT_EQ(keyframes[1].scans[0].time, 1.5);
  keyframes = keyframes_of(without_odometry, options, &dropped);
  EXPECT_EQ(keyframes.size(), 10U) << "a keyframe each where nothing tells of motion";
  EXPECT_EQ(count_scans(keyframes), 10U);
}

TEST(Scans, AGapInOdometryLosesNone) {
  Objects objects = pairs(true);
  objects.erase(objects.begin() + 3);  // the motion from the second frame to the third
  SourceOptions options;
  options.keyframes.min_distance = 2.5;
  DropReport dropped;
  const auto keyframes = keyframes_of(objects, options, &dropped);
  EXPECT_TRUE(dropped.empty());
  EXPECT_EQ(count_scans(keyframes), 18U) << "those after the last keyframe have no place";
  EXPECT_EQ(keyframes[1].time, 1) << "the step before the gap";
  EXPECT_TRUE(keyframes[1].odometry);
  EXPECT_EQ(keyframes[2].time, 2);
  EXPECT_FALSE(keyframes[2].odometry);
  EXPECT_TRUE(keyframes[2].scans.front().T_keyframe_robot.matrix().isIdentity(0));
}

TEST(Scans, WhereOdometryRestsTheyTellOfMotion) {
  const testing::FloorPlan plan = testing::ring();
  const std::vector<SE2> way = testing::way_around_ring(1, 0.1);
  for (const bool moves : {true, false}) {
    std::mt19937 random(1);
    Objects objects;
    for (std::size_t i = 0; i < 200; ++i) {
      LaserScan seen = plan.scan(moves ? way[i] : way[0], 181, 0.01, random);
      seen.time = 1e9 + 0.2 * static_cast<double>(i);
      if (i > 0) objects.push_back(motion_2d({0, 0, 0}, 0.01));
      objects.push_back(frame({to_mrpt(seen)}));
    }
    SourceOptions options;
    options.keyframes = kScanKeyframes;
    options.follows_scans = true;
    const auto keyframes = keyframes_of(objects, options);
    EXPECT_EQ(count_scans(keyframes), 200U);
    if (moves) {
      EXPECT_GT(keyframes.size(), 30U) << "20 m of way";
      EXPECT_LT(keyframes.size(), 60U);
    } else {
      EXPECT_EQ(keyframes.size(), 2U);
    }
  }
}

TEST(Scans, ARobotThatStandsStillDoesNotFillTheMemory) {
  ScanCollector collector;
  DropReport report;
  for (int i = 0; i < 10'000; ++i) {
    collector.move(OdometryIncrement{}, report);
    LaserScan scan;
    scan.time = i;
    collector.add(scan, report);
  }
  const auto scans = collector.release();
  EXPECT_LE(scans.size(), ScanCollector::kMost);
  EXPECT_GE(scans.size(), ScanCollector::kMost / 2);
  EXPECT_EQ(scans.back().time, 9999);
  EXPECT_LT(scans.front().time, 200);
  ASSERT_EQ(report.size(), 1U);
  EXPECT_EQ(report.begin()->second + scans.size(), 10'000U);
  EXPECT_TRUE(collector.release().empty());
}

TEST(Scans, HalvedOnesAreTold) {
  const auto halved = scan(1, 180);
  halved->aperture = static_cast<float>(M_PI_2);
  SourceOptions options;
  DropReport warnings;
  keyframes_of({frame({halved}), frame({scan(2, 180)}), frame({scan(3, 90)})}, options, nullptr,
               &warnings);
  ASSERT_EQ(warnings.size(), 1U);
  EXPECT_NE(warnings.begin()->first.find("--set sensor.fov_deg=180"), std::string::npos);
  EXPECT_EQ(warnings.begin()->second, 1U);
  options.scans.field_of_view = M_PI;
  keyframes_of({frame({halved})}, options, nullptr, &warnings);
  EXPECT_TRUE(warnings.empty());
}

TEST(Scans, ContentsTellThatALogHasThem) {
  const TemporaryFile log("scans.rawlog");
  write_log(log.path(), {frame({scan(1), scan(1, 0), observation(1)})});
  const LogContents contents = read_contents(log.path(), {});
  EXPECT_EQ(contents.scans, 1U);
  EXPECT_EQ(contents.with_range.all, 1U);
  EXPECT_EQ(contents.observations.at("CObservation2DRangeScan"), 2U);
}

}  // namespace
}  // namespace hybrid
