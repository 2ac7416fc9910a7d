// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, the hybrid mapping authors

#include <gtest/gtest.h>
#include <mrpt/obs/CObservationIMU.h>
#include <mrpt/obs/CObservationRobotPose.h>

#include <cmath>

#include "mrpt_plugins/input/arrival_order.h"
#include "mrpt_plugins/input/odometry_reset.h"
#include "mrpt_plugins/input/rawlog_reader.h"
#include "tests/mrpt_plugins/input/log_files.h"

namespace hybrid {
namespace {

using mrpt::poses::CPose3D;

std::vector<LogStep> steps_of(const std::string& log, const RawlogOptions& options = {}) {
  RawlogReader reader(log, options);
  std::vector<LogStep> all;
  while (auto step = reader.next()) all.push_back(std::move(*step));
  return all;
}

mrpt::obs::CObservation::Ptr imu(double time) {
  auto o = mrpt::obs::CObservationIMU::Create();
  o->timestamp = mrpt::Clock::fromDouble(time);
  return o;
}

mrpt::obs::CObservation::Ptr robot_pose(double time, const CPose3D& pose) {
  auto o = mrpt::obs::CObservationRobotPose::Create();
  o->timestamp = mrpt::Clock::fromDouble(time);
  o->pose.mean = pose;
  return o;
}

TEST(ArrivalOrder, WithinTheWindowStampsDecideAndEqualOnesKeepTheirOrder) {
  ArrivalOrder<char> order(1.0);
  std::string given;
  const auto take = [&](bool all) {
    while (const auto next = order.next(all)) given += *next;
  };
  for (const auto& [time, thing] :
       {std::pair{0.0, 'a'}, {0.9, 'c'}, {0.5, 'b'}, {0.9, 'd'}, {2.0, 'f'}, {1.5, 'e'}}) {
    order.add(time, thing);
    take(false);
  }
  EXPECT_EQ(given, "abcd");  // nothing of 1.0 or before can come any more, within the window
  take(true);
  EXPECT_EQ(given, "abcdef");
}

TEST(LogConventions, WhatArrivesLateIsPutWhereItsStampSays) {
  for (const double late : {0.3, 0.5, 1.0, 1.9}) {
    const TemporaryFile log("late.rawlog");
    std::vector<std::pair<double, mrpt::serialization::CSerializable::Ptr>> arrivals;
    for (int i = 0; i < 200; ++i) {
      arrivals.emplace_back(0.05 * i, absolute_odometry(0.05 * i, {0.05 * i, 0, 0}));
    }
    for (int i = 0; i < 40; ++i)
      arrivals.emplace_back(0.2 * i + 0.13 + late, observation(0.2 * i + 0.13));
    std::stable_sort(arrivals.begin(), arrivals.end(),
                     [](const auto& a, const auto& b) { return a.first < b.first; });
    Objects objects;
    for (auto& [time, object] : arrivals) objects.push_back(std::move(object));
    write_log(log.path(), objects);
    const auto all = steps_of(log.path());
    ASSERT_EQ(all.size(), 40U) << late;
    for (std::size_t i = 1; i < all.size(); ++i) {
      ASSERT_TRUE(all[i].odometry) << late << " " << i;
      EXPECT_NEAR(all[i].odometry->mean.x(), 0.2, 1e-6) << late << " " << i;
    }
  }
}

TEST(LogConventions, WhatIsLaterThanTheWindowIsCounted) {
  const TemporaryFile log("too_late.rawlog");
  write_log(log.path(),
            {observation(10), observation(20), observation(25), observation(11), observation(30)});
  RawlogReader reader(log.path());
  std::size_t steps = 0;
  while (reader.next()) ++steps;
  EXPECT_EQ(steps, 4U);
  EXPECT_EQ(reader.warnings().at("observation dropped: time goes backwards"), 1U);
}

TEST(LogConventions, WhatNobodyUsesMakesNoStep) {
  const TemporaryFile log("imu.rawlog");
  Objects objects;
  for (int i = 0; i < 50; ++i) {
    objects.push_back(imu(0.1 * i));
    if (i % 10 == 0) objects.push_back(observation(0.1 * i + 0.05));
  }
  write_log(log.path(), objects);
  EXPECT_EQ(steps_of(log.path()).size(), 5U);
  RawlogReader reader(log.path());
  while (reader.next()) {
  }
  EXPECT_EQ(reader.observations().at("CObservationIMU"), 50U);
  write_log(log.path(), {imu(1), imu(2)});  // a log of nothing else has one, to say so
  EXPECT_EQ(steps_of(log.path()).size(), 1U);
}

TEST(LogConventions, PosesOfTheRobotAreOdometryWhereThereIsNoOther) {
  const TemporaryFile log("poses.rawlog");
  Objects poses, both;
  for (int i = 0; i < 10; ++i) {
    poses.push_back(robot_pose(i, {2.0 * i, 0, 0, 0, 0, 0}));
    poses.push_back(observation(i));
    both.push_back(absolute_odometry(i, {3.0 * i, 0, 0}));
    both.push_back(robot_pose(i, {2.0 * i, 0, 0, 0, 0, 0}));
    both.push_back(observation(i));
  }
  for (const auto& [objects, way] : {std::pair{poses, 2.0}, {both, 3.0}}) {
    write_log(log.path(), objects);
    const auto all = steps_of(log.path());
    ASSERT_EQ(all.size(), 10U);
    for (std::size_t i = 1; i < all.size(); ++i) {
      ASSERT_TRUE(all[i].odometry);
      EXPECT_TRUE(all[i].odometry->is_planar);
      EXPECT_NEAR(all[i].odometry->mean.x(), way, 1e-6);
    }
  }
  Objects space;
  for (int i = 0; i < 10; ++i) {
    space.push_back(robot_pose(i, {0, 0, 1.5 * i, 0, 0.1, 0}));
    space.push_back(observation(i));
  }
  write_log(log.path(), space);
  const auto all = steps_of(log.path());
  ASSERT_TRUE(all.at(5).odometry);
  EXPECT_FALSE(all[5].odometry->is_planar);
  EXPECT_NEAR(all[5].odometry->mean.norm(), 1.5, 1e-6);
}

/// Reads a log to its end, in which the robot drives half a metre between two frames.
std::size_t steps_without_odometry(RawlogReader& reader) {
  std::size_t missing = 0;
  while (const auto step = reader.next()) {
    if (!step->odometry) {
      ++missing;
    } else {
      EXPECT_LE(std::abs(step->odometry->mean.x()), 0.5 + 1e-9) << step->index;
    }
  }
  return missing;
}

TEST(LogConventions, OdometryThatStartsAnewIsMissingThere) {
  const TemporaryFile log("reset.rawlog");
  Objects objects;
  for (int i = 0; i < 100; ++i) {
    objects.push_back(absolute_odometry(i, {0.5 * (i % 60), 0, 0}));
    objects.push_back(observation(i + 0.5));
  }
  write_log(log.path(), objects);
  RawlogReader reader(log.path());
  EXPECT_EQ(steps_without_odometry(reader), 2U);  // the first one, and where it starts anew
  EXPECT_EQ(reader.warnings().at(
                "odometry dropped: it starts anew, so that the motion there is not known"),
            1U);
}

TEST(OdometryReset, ARobotThatDrivesBackToItsStartDoesNotStartAnew) {
  OdometryReset reset;
  for (int lap = 0; lap < 3; ++lap) {
    for (int i = 0; i < 100; ++i) {
      const double a = 2 * M_PI * i / 100;
      EXPECT_FALSE(reset.at({10 - 10 * std::cos(a), 10 * std::sin(a), 0})) << i;
    }
  }
  OdometryReset jump;  // a slip that leads elsewhere
  for (int i = 0; i < 10; ++i) EXPECT_FALSE(jump.at({0.1 * i, 0, 0}));
  EXPECT_FALSE(jump.at({5, 5, 0}));
}

TEST(LogConventions, WhereOdometryIsMissingWhileTheRobotMovesItIsNotAStraightLine) {
  const TemporaryFile log("gap.rawlog");
  Objects objects;
  for (int i = 0; i < 100; ++i) {
    const double x = i < 50 ? 0.5 * i : 25, y = i < 50 ? 0 : 0.5 * (i - 50);  // around a corner
    if (i < 40 || i > 60) objects.push_back(absolute_odometry(i, {x, y, i < 50 ? 0 : M_PI / 2}));
    objects.push_back(observation(i + 0.5));
  }
  write_log(log.path(), objects);
  RawlogReader reader(log.path());
  EXPECT_EQ(steps_without_odometry(reader),
            1U + 22U + 1U);  // the first one, those in the gap, and that behind it
  EXPECT_EQ(reader.warnings().at(OdometryGap::kMissing), 1U);
}

// Actions tell the motion; a few readings tell where the robot was between frames.
TEST(LogConventions, ReadingsBesideActionsMayBeFew) {
  const TemporaryFile log("few_readings.rawlog");
  Objects objects;
  for (int i = 0; i < 100; ++i) {
    if (i % 40 < 15) objects.push_back(absolute_odometry(i - 0.5, {0.5 * i - 0.25, 0, 0}));
    objects.push_back(motion_2d({0.5, 0, 0}, 0.1));
    objects.push_back(frame({observation(i)}));
  }
  write_log(log.path(), objects);
  RawlogReader reader(log.path());
  EXPECT_EQ(steps_without_odometry(reader), 0U);
  EXPECT_EQ(reader.warnings().count(OdometryGap::kMissing), 0U);
}

TEST(OdometryGap, IsWhereTheRobotMovedForLongerThanUsual) {
  const auto count = [](const std::vector<std::pair<double, double>>& poses) {
    OdometryGap gap;
    int found = 0;
    for (const auto& [time, x] : poses) {
      found += gap.before(time, Eigen::Isometry3d(Eigen::Translation3d(x, 0, 0)));
    }
    return found;
  };
  std::vector<std::pair<double, double>> even, standing, bursts;
  for (int i = 0; i < 100; ++i) {
    even.emplace_back(i < 50 ? 0.1 * i : 0.1 * i + 5, i < 50 ? 0.05 * i : 0.05 * i + 2.5);
    standing.emplace_back(even.back().first, 0.05 * i);
    bursts.emplace_back(0.2 * (i / 10) + 0.001 * (i % 10), 0.02 * i);
  }
  EXPECT_EQ(count(even), 1);
  EXPECT_EQ(count(standing), 0);
  EXPECT_EQ(count(bursts), 0);
}

TEST(LogConventions, AClockThatIsTooCoarseIsSaid) {
  const TemporaryFile log("coarse.rawlog");
  const auto says = [&](double tick) {
    Objects objects;
    for (int i = 0; i < 200; ++i) {
      const double time = std::floor(0.05 * i / tick) * tick;
      objects.push_back(absolute_odometry(time, {0.05 * i, 0, 0}));
      if (i % 20 == 0) objects.push_back(observation(time));
    }
    write_log(log.path(), objects);
    RawlogReader reader(log.path());
    while (reader.next()) {
    }
    EXPECT_NEAR(reader.repeated_stamps(), tick < 0.1 ? 0.0 : 0.95, 0.06);
    for (const auto& [what, count] : reader.warnings()) {
      if (what.find("190 of 200 stamps") == 0) return true;
    }
    return false;
  };
  EXPECT_TRUE(says(1));
  EXPECT_FALSE(says(0.05));
}

}  // namespace
}  // namespace hybrid
