// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, the hybrid mapping authors

#include "mrpt_plugins/input/rawlog_reader.h"

#include <gtest/gtest.h>
#include <mrpt/obs/CActionRobotMovement3D.h>
#include <mrpt/version.h>

#include <filesystem>
#include <set>

#include "mrpt_plugins/bridge/pose_conversions.h"
#include "mrpt_plugins/evaluation/ground_truth.h"
#include "mrpt_plugins/input/detections.h"
#include "tests/mrpt_plugins/input/log_files.h"

namespace hybrid {
namespace {

using mrpt::poses::CPose2D;
using mrpt::poses::CPose3D;

constexpr const char* kDatasets = "/usr/share/mrpt/datasets/";

struct LogSummary {
  std::size_t steps = 0, with_odometry = 0, detections = 0;
  std::set<std::int64_t> ids;
  double range_rms = 0, angle_rms = 0;
  bool planar = true;
  LogStatus status = LogStatus::kReading;
  DropReport dropped;
};

/// Reads a log of MRPT's and compares each detection with the true landmark seen from row i of the
/// true path.
LogSummary summarise(const std::string& name) {
  const std::string stem = kDatasets + name;
  const auto path = read_true_path(stem + "_ground_truth_robot_path.txt");
  std::map<std::int64_t, mrpt::math::TPoint3D> landmarks;
  for (const auto& l : read_true_landmarks(stem + "_ground_truth.txt")) {
    landmarks[l.id] = {l.position.x(), l.position.y(), l.position.z()};
  }
  LogSummary summary;
  RawlogReader reader(stem + ".rawlog");
  while (const auto step = reader.next()) {
    EXPECT_EQ(step->index, summary.steps++);
    if (step->odometry) {
      ++summary.with_odometry;
      summary.planar = summary.planar && step->odometry->is_planar;
    }
    for (const auto& observation : step->observations) {
      const auto frame = detections_in(*observation, {}, summary.dropped);
      if (!frame) continue;
      const CPose3D T_map_sensor = path.at(step->index) + to_mrpt(frame->T_robot_sensor);
      for (const Detection& d : frame->detections) {
        ++summary.detections;
        if (!d.id) continue;
        summary.ids.insert(*d.id);
        double range = 0, yaw = 0, pitch = 0;
        T_map_sensor.sphericalCoordinates(landmarks.at(*d.id), range, yaw, pitch);
        summary.range_rms += (range - d.range) * (range - d.range);
        summary.angle_rms += std::pow(std::remainder(yaw - d.yaw, 2 * M_PI), 2);
      }
    }
  }
  summary.range_rms = std::sqrt(summary.range_rms / static_cast<double>(summary.detections));
  summary.angle_rms = std::sqrt(summary.angle_rms / static_cast<double>(summary.detections));
  summary.status = reader.status();
  return summary;
}

bool datasets_missing() {
  return !std::filesystem::exists(std::string(kDatasets) + "kf-slam_demo.rawlog");
}

TEST(RawlogReader, KfSlamDemoAlignsWithItsTruth) {
  if (datasets_missing()) GTEST_SKIP() << "package mrpt-common-data is not installed";
  const LogSummary s = summarise("kf-slam_demo");
  EXPECT_EQ(s.steps, 250U);
  EXPECT_EQ(s.with_odometry, 249U);
  EXPECT_EQ(s.detections, 3607U);
  EXPECT_EQ(s.ids.size(), 70U);
  EXPECT_TRUE(s.planar);
  EXPECT_NEAR(s.range_rms, 0.0100, 0.0003);
  EXPECT_NEAR(s.angle_rms, 0.00174, 0.00006);
  EXPECT_EQ(s.status, LogStatus::kComplete);
  EXPECT_TRUE(s.dropped.empty());
}

TEST(RawlogReader, SpatialLogsAlignWithTheirTruth) {
  if (datasets_missing()) GTEST_SKIP() << "package mrpt-common-data is not installed";
  for (const auto& [name, detections, ids] :
       {std::tuple{"kf-slam_6D_demo", 5824U, 48U}, {"kf-slam_6D_demo_noncentered", 8564U, 44U}}) {
    const LogSummary s = summarise(name);
    EXPECT_EQ(s.steps, 600U) << name;
    EXPECT_EQ(s.detections, detections) << name;
    EXPECT_EQ(s.ids.size(), ids) << name;
    EXPECT_FALSE(s.planar) << name;
    EXPECT_NEAR(s.range_rms, 0.0100, 0.0003) << name;
    EXPECT_EQ(s.status, LogStatus::kComplete) << name;
  }
}

TEST(RawlogReader, HiddenIdsAreNone) {
  if (datasets_missing()) GTEST_SKIP() << "package mrpt-common-data is not installed";
  const LogSummary s = summarise("kf-slam_6D_demo_DA");
  EXPECT_EQ(s.steps, 250U);
  EXPECT_EQ(s.detections, 1515U);
  EXPECT_TRUE(s.ids.empty());
}

TEST(RawlogReader, EveryMrptLogIsReadToItsEnd) {
  if (datasets_missing()) GTEST_SKIP() << "package mrpt-common-data is not installed";
  for (const auto& entry : std::filesystem::directory_iterator(kDatasets)) {
    if (entry.path().extension() != ".rawlog") continue;
    // MRPT 3 changed the format of CObservationRotatingScan, but not its version number.
    if (MRPT_VERSION >= 0x30000 && entry.path().stem().string().find("rot_scan_") == 0) continue;
    RawlogReader reader(entry.path().string());
    std::size_t steps = 0;
    while (reader.next()) ++steps;
    EXPECT_EQ(reader.status(), LogStatus::kComplete) << reader.message();
    EXPECT_GT(steps, 0U) << entry.path();
  }
}

/// A double has not enough digits for the ticks of 100 ns since 1601.
TEST(RawlogReader, TimesKeepTheirMicroseconds) {
  const TemporaryFile log("times.rawlog");
  constexpr std::int64_t kYear1970 = 116'444'736'000'000'000, kStart = 12'567'609'670'000'000;
  Objects objects;
  for (std::int64_t ticks = 0; ticks < 20; ticks += 3) {
    auto seen = observation(0);
    seen->timestamp = mrpt::Clock::time_point(mrpt::Clock::duration(kYear1970 + kStart + ticks));
    objects.push_back(frame({seen}));
  }
  write_log(log.path(), objects);
  RawlogReader reader(log.path());
  for (std::int64_t ticks = 0; ticks < 20; ticks += 3) {
    const auto step = reader.next();
    ASSERT_TRUE(step);
    EXPECT_EQ(step->time, static_cast<double>(kStart + ticks) / 1e7) << ticks;
    ASSERT_EQ(step->observations.size(), 1U);
    DropReport dropped;
    const auto detections = detections_in(*step->observations.front(), {}, dropped);
    ASSERT_TRUE(detections);
    EXPECT_EQ(detections->time, step->time) << ticks;
  }
}

/// Actions composed between frames, frames before any action, actions after the last frame.
TEST(RawlogReader, PairsOfAnyOrder) {
  const TemporaryFile log("pairs.rawlog");
  write_log(log.path(),
            {frame({observation(10)}), motion_2d({1, 0, 0}, 0.1), motion_2d({0, 2, M_PI / 2}, 0.1),
             frame({observation(12)}), frame({}), motion_2d({1, 0, 0}, 0.1)});
  RawlogReader reader(log.path());
  const auto a = reader.next(), b = reader.next(), c = reader.next();
  ASSERT_TRUE(a && b && c);
  EXPECT_FALSE(reader.next());
  EXPECT_EQ(reader.status(), LogStatus::kComplete);
  EXPECT_FALSE(a->odometry);
  EXPECT_EQ(a->time, 10);
  ASSERT_TRUE(b->odometry);
  EXPECT_NEAR(b->odometry->mean.distanceTo(CPose3D(1, 2, 0, M_PI / 2, 0, 0)), 0, 1e-9);
  // The first motion's heading noise swings the second one's 2 m in y into x; then the frame turns.
  EXPECT_NEAR(b->odometry->covariance(1, 1), 0.01 + 0.01 + 4 * 0.01, 1e-9);
  EXPECT_NEAR(b->odometry->covariance(0, 0), 0.02, 1e-9);
  EXPECT_NEAR(b->odometry->covariance(5, 5), 0.02, 1e-9);
  EXPECT_FALSE(c->odometry);
  EXPECT_EQ(c->time, 13);  // no timestamp: one period after the frame before
  EXPECT_EQ(reader.warnings().at("timestamp missing: synthesised"), 1U);
}

TEST(RawlogReader, LogThatBeginsWithAnAction) {
  const TemporaryFile log("action_first.rawlog");
  write_log(log.path(), {motion_2d({1, 0, 0}, 0.1), frame({observation(10)}),
                         motion_2d({2, 0, 0}, 0.1), frame({observation(11)})});
  RawlogReader reader(log.path());
  const auto a = reader.next(), b = reader.next();
  ASSERT_TRUE(a && b && a->odometry && b->odometry);
  EXPECT_EQ(a->odometry->mean.x(), 1);
  EXPECT_EQ(b->odometry->mean.x(), 2);
}

TEST(RawlogReader, BadMotionIsDroppedAndCounted) {
  const TemporaryFile log("bad_motion.rawlog");
  write_log(log.path(),
            {frame({observation(1)}), motion_2d({NAN, 0, 0}, 0.1), frame({observation(2)}),
             motion_2d({1, 0, 0}, 0.0), frame({observation(3)})});
  RawlogReader reader(log.path());
  const auto a = reader.next(), b = reader.next(), c = reader.next();
  ASSERT_TRUE(a && b && c);
  EXPECT_FALSE(b->odometry);
  ASSERT_TRUE(c->odometry);
  EXPECT_DOUBLE_EQ(c->odometry->covariance(0, 0), 1e-10);
  EXPECT_EQ(reader.warnings().size(), 2U);
}

mrpt::serialization::CSerializable::Ptr motion_3d(const CPose3D& motion) {
  mrpt::obs::CActionRobotMovement3D action;
  action.poseChange.mean = motion;
  action.poseChange.cov.setDiagonal(6, 0.01);
  return std::make_shared<mrpt::obs::CActionCollection>(action);
}

TEST(RawlogReader, AMotionOfWhichPartIsUnusableIsUnknown) {
  const TemporaryFile log("part_of_motion.rawlog");
  write_log(log.path(),
            {frame({observation(1)}), motion_2d({1, 0, 0}, 0.1), motion_2d({NAN, 0, 0}, 0.1),
             motion_2d({1, 0, 0}, 0.1), frame({observation(2)}), motion_2d({2, 0, 0}, 0.1),
             frame({observation(3)})});
  RawlogReader reader(log.path());
  const auto a = reader.next(), b = reader.next(), c = reader.next();
  ASSERT_TRUE(a && b && c);
  EXPECT_FALSE(b->odometry);
  ASSERT_TRUE(c->odometry);
  EXPECT_EQ(c->odometry->mean.x(), 2);
}

TEST(RawlogReader, MotionsThatCannotBeAreDroppedAndCounted) {
  CPose3D sheared(1, 0, 0, 0, 0, 0);
  mrpt::math::CMatrixDouble33 R;
  R.setIdentity();
  R(2, 0) = 0.1;
  sheared.setRotationMatrix(R);
  const char* invalid = "odometry dropped: not finite or covariance not valid";
  const char* too_far =
      "odometry dropped: farther, or less certain, than [reader] max_speed allows";
  for (const auto& [motion, reason] : {std::pair{motion_2d({1e4, 0, 0}, 0.1), too_far},
                                       {motion_2d({0, 1e300, 0}, 0.1), too_far},
                                       {motion_2d({1, 0, 0}, 1e6), too_far},
                                       {motion_2d({1, 0, 0}, 10), too_far},
                                       {motion_3d({0, 0, 500, 0, 0, 0}), too_far},
                                       {motion_3d(sheared), invalid}}) {
    const TemporaryFile log("absurd_motion.rawlog");
    write_log(log.path(), {frame({observation(1)}), motion_2d({1, 0, 0}, 0.1),
                           frame({observation(2)}), motion, frame({observation(3)})});
    RawlogReader reader(log.path());
    const auto a = reader.next(), b = reader.next(), c = reader.next();
    ASSERT_TRUE(a && b && c) << reader.message();
    EXPECT_TRUE(b->odometry);
    EXPECT_FALSE(c->odometry);
    EXPECT_EQ(reader.warnings(), (DropReport{{reason, 1}}));
  }
}

TEST(RawlogReader, FastIsWhatTheTimeBetweenFramesDoesNotAllow) {
  const TemporaryFile log("speed.rawlog");
  write_log(log.path(),
            {frame({observation(0)}), motion_2d({9, 0, 0}, 0.1), frame({observation(0.001)}),
             motion_2d({90, 0, 0}, 0.1), frame({observation(10)}), motion_2d({11, 0, 0}, 0.1),
             frame({observation(11)})});
  RawlogOptions options;
  options.max_speed = 10;
  RawlogReader reader(log.path(), options);
  reader.next();
  EXPECT_TRUE(reader.next()->odometry) << "time stamps that stand still: a period is allowed";
  EXPECT_TRUE(reader.next()->odometry);
  EXPECT_FALSE(reader.next()->odometry);
}

TEST(RawlogReader, AReadingOfOdometryThatJumpsAwayAndBack) {
  const TemporaryFile log("jump.rawlog");
  Objects objects;
  for (int i = 0; i < 20; ++i) {
    objects.push_back(absolute_odometry(i, {i == 10 ? 1e20 : 1.0 * i, 0, 0}));
    objects.push_back(observation(i + 0.5));
  }
  write_log(log.path(), objects);
  RawlogReader reader(log.path());
  int steps = 0, moved = 0;
  while (const auto step = reader.next()) {
    ++steps;
    if (!step->odometry) continue;
    ++moved;
    EXPECT_LT(step->odometry->mean.x(), 2);
  }
  EXPECT_EQ(steps, 20);
  EXPECT_EQ(moved, 16);  // not the first one, nor those to, at and from the jump
}

TEST(RawlogReader, ObservationsOnlyInterpolateOdometry) {
  const TemporaryFile log("observations.rawlog");
  write_log(log.path(),
            {absolute_odometry(0, {5, 5, M_PI / 2}), observation(0.5), observation(0.5),
             absolute_odometry(1, {5, 7, M_PI / 2}), observation(1.0), observation(1.75),
             absolute_odometry(2, {5, 9, M_PI / 2}), observation(3)});
  RawlogReader reader(log.path());
  std::vector<LogStep> steps;
  while (auto step = reader.next()) steps.push_back(*step);
  ASSERT_EQ(steps.size(), 4U);
  EXPECT_EQ(steps[0].observations.size(), 2U);
  EXPECT_FALSE(steps[0].odometry);
  const double expected[] = {0, 1.0, 1.5, 0.5};
  for (std::size_t i = 1; i < 4; ++i) {
    ASSERT_TRUE(steps[i].odometry) << i;
    EXPECT_NEAR(steps[i].odometry->mean.x(), expected[i], 1e-9) << i;
    EXPECT_NEAR(steps[i].odometry->mean.y(), 0, 1e-9) << i;
    EXPECT_GT(steps[i].odometry->covariance(0, 0), 0) << i;
  }
}

TEST(RawlogReader, BeforeAndAfterTheOdometryMotionIsNotKnown) {
  const TemporaryFile log("late_odometry.rawlog");
  Objects objects;
  for (int i = 0; i < 100; ++i) {
    if (i >= 40 && i < 60) objects.push_back(absolute_odometry(0.5 * i, {0.25 * i, 0, 0}));
    objects.push_back(observation(0.5 * i));
  }
  write_log(log.path(), objects);
  RawlogReader reader(log.path());
  while (const auto step = reader.next()) {
    const bool is_known = step->index >= 39 && step->index < 62;  // up to a period beyond
    EXPECT_EQ(step->odometry.has_value(), is_known) << step->index;
  }
}

TEST(RawlogReader, ObservationsWithoutOdometryAllComeOut) {
  const TemporaryFile log("no_odometry.rawlog");
  std::vector<mrpt::serialization::CSerializable::Ptr> objects;
  for (int i = 0; i < 600; ++i) objects.push_back(observation(i));
  write_log(log.path(), objects);
  RawlogReader reader(log.path());
  std::size_t steps = 0;
  while (const auto step = reader.next()) {
    EXPECT_EQ(step->time, static_cast<double>(steps++));
    EXPECT_FALSE(step->odometry);
  }
  EXPECT_EQ(steps, 600U);
}

TEST(RawlogReader, TimesMayBeginBeforeZero) {
  const TemporaryFile log("negative.rawlog");
  write_log(log.path(), {absolute_odometry(-9, {0, 0, 0}), observation(-8), observation(-7),
                         absolute_odometry(-6, {3, 0, 0})});
  RawlogReader sensed(log.path());
  std::vector<double> times;
  while (const auto step = sensed.next()) times.push_back(step->time);
  EXPECT_EQ(times, (std::vector<double>{-8, -7}));
  EXPECT_EQ(sensed.warnings(), DropReport{});

  write_log(log.path(), {frame({observation(-5)}), motion_2d({1, 0, 0}, 0.1),
                         frame({observation(-4)}), motion_2d({1, 0, 0}, 0.1)});
  RawlogReader framed(log.path());
  times.clear();
  while (const auto step = framed.next()) times.push_back(step->time);
  EXPECT_EQ(times, (std::vector<double>{-5, -4}));
  EXPECT_EQ(framed.warnings(), DropReport{});
}

TEST(RawlogReader, TimeThatGoesBackwardsAndGaps) {
  const TemporaryFile log("backwards.rawlog");
  Objects frames;
  for (const double t : {1.0, 2.0, 1.5, 3.0, 4.0, 60.0}) {
    frames.push_back(frame({observation(t)}));
    frames.push_back(motion_2d({1, 0, 0}, 0.1));
  }
  write_log(log.path(), frames);
  RawlogReader reader(log.path());
  std::vector<double> times;
  while (const auto step = reader.next()) {
    times.push_back(step->time);
    EXPECT_EQ(step->odometry.has_value(), times.size() > 1);
  }
  EXPECT_EQ(times, (std::vector<double>{1, 2, 2, 3, 4, 60}));
  EXPECT_EQ(
      reader.warnings(),
      (DropReport{{"timestamp repaired: it went backwards, that of the frame before taken", 1},
                  {"frames missing: a gap of over 10 times the usual period", 1}}));

  write_log(log.path(), {absolute_odometry(0, {0, 0, 0}), observation(1), observation(0.5),
                         absolute_odometry(2, {2, 0, 0}), absolute_odometry(1, {9, 9, 0}),
                         observation(3), absolute_odometry(4, {4, 0, 0})});
  RawlogOptions in_order_of_arrival;
  in_order_of_arrival.arrival_window = 0;
  RawlogReader alone(log.path(), in_order_of_arrival);
  std::vector<LogStep> steps;
  while (auto step = alone.next()) steps.push_back(*step);
  ASSERT_EQ(steps.size(), 2U);
  EXPECT_NEAR(steps[1].odometry->mean.x(), 2, 1e-9);
  EXPECT_EQ(alone.warnings(), (DropReport{{"observation dropped: time goes backwards", 1},
                                          {"odometry dropped: time goes backwards", 1}}));
}

}  // namespace
}  // namespace hybrid
