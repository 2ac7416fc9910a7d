// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, the hybrid mapping authors

#include "mrpt_plugins/input/poses_between.h"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>

#include "mrpt_plugins/bridge/pose_conversions.h"
#include "mrpt_plugins/input/rawlog_reader.h"
#include "tests/mrpt_plugins/input/log_files.h"

namespace hybrid {
namespace {

using mrpt::poses::CPose2D;

Eigen::Isometry3d at(double x) {
  return to_isometry({x, 0, 0, 0, 0, 0});
}

/// Times of entries less a start, with where they are ahead of their step.
using Rows = std::vector<std::pair<double, double>>;
Rows rows_of(const std::vector<PoseBetween>& poses, double start = 0) {
  Rows rows;
  for (const PoseBetween& pose : poses) {
    rows.emplace_back(std::round(1e3 * (pose.time - start)) / 1e3,
                      std::round(1e6 * pose.T_pose_robot.translation().x()) / 1e6);
  }
  return rows;
}

TEST(PosesBetween, ReadingsAreSeenFromTheStepAfterThem) {
  PosesBetween poses;
  poses.add(0.5, at(5));
  EXPECT_TRUE(poses.to(1, at(10)).empty()) << "no step before";
  poses.add(1, at(10));
  poses.add(1.5, at(15));
  poses.add(1.5, at(16));
  poses.add(1.2, at(12));
  poses.add(2.5, at(25));
  EXPECT_EQ(rows_of(poses.to(2, at(20))), (Rows{{1.5, -5}}));
  EXPECT_EQ(rows_of(poses.rest()), (Rows{{2.5, 5}}));
  poses.lose(3);
  poses.add(3.5, at(35));
  EXPECT_TRUE(poses.rest().empty());
  EXPECT_TRUE(poses.to(4, at(40)).empty());
}

TEST(PosesBetween, OfManyAPartIsKept) {
  PosesBetween poses;
  poses.to(0, at(0));
  const auto count = static_cast<int>(3 * PosesBetween::kMost);
  for (int i = 1; i <= count; ++i) poses.add(i, at(i));
  const auto kept = poses.to(count, at(count));
  EXPECT_LE(kept.size(), PosesBetween::kMost);
  EXPECT_GE(kept.size(), PosesBetween::kMost / 2);
  for (std::size_t i = 1; i < kept.size(); ++i) EXPECT_EQ(kept[i].time - kept[i - 1].time, 4);
}

constexpr double kStart = 1e9;

/// What steps of a log tell of the odometry between them, and after the last one.
struct Between {
  std::vector<Rows> steps;
  Rows rest;
};
Between between_of(const Objects& objects) {
  const TemporaryFile file("between.rawlog");
  write_log(file.path(), objects);
  RawlogReader reader(file.path());
  Between out;
  while (const auto step = reader.next()) out.steps.push_back(rows_of(step->between, kStart));
  out.rest = rows_of(reader.rest(), kStart);
  return out;
}

TEST(PosesBetween, OfSingleObservations) {
  Objects log;
  for (int i = 0; i <= 10; ++i) {
    log.push_back(absolute_odometry(kStart + i, {double(i), 0, 0}));
    if (i == 2 || i == 8) log.push_back(observation(kStart + i));
    if (i == 5) log.push_back(observation(kStart + 5.5));
  }
  const Between read = between_of(log);
  ASSERT_EQ(read.steps.size(), 3U);
  EXPECT_EQ(read.steps[0], Rows());
  EXPECT_EQ(read.steps[1], (Rows{{3, -2.5}, {4, -1.5}, {5, -0.5}}));
  EXPECT_EQ(read.steps[2], (Rows{{6, -2}, {7, -1}, {8, 0}}));
  EXPECT_EQ(read.rest, (Rows{{9, 1}, {10, 2}}));
}

TEST(PosesBetween, NoneAroundAReadingThatCannotBe) {
  Objects log;
  for (int i = 0; i <= 10; ++i) {
    log.push_back(absolute_odometry(kStart + i, {i == 5 ? 1000.0 : i, 0, 0}));
    if (i == 2 || i == 8) log.push_back(observation(kStart + i));
  }
  EXPECT_EQ(between_of(log).steps.at(1), Rows());
}

TEST(PosesBetween, OfSeveralActionsBeforeAFrame) {
  const auto moved = [](double time) {
    const auto actions =
        std::dynamic_pointer_cast<mrpt::obs::CActionCollection>(motion_2d({1, 0, 0}, 0.1));
    actions->get(0)->timestamp = mrpt::Clock::fromDouble(kStart + time);
    return actions;
  };
  const Between read = between_of({frame({observation(kStart)}), moved(1), moved(2), moved(3),
                                   frame({observation(kStart + 3)}), moved(4),
                                   frame({observation(kStart + 4)}), moved(5), moved(6)});
  ASSERT_EQ(read.steps.size(), 3U);
  EXPECT_EQ(read.steps[1], (Rows{{1, -2}, {2, -1}, {3, 0}}));
  EXPECT_EQ(read.steps[2], (Rows{{4, 0}}));
  EXPECT_EQ(read.rest, (Rows{{5, 1}, {6, 2}}));
}

TEST(PosesBetween, OfReadingsBetweenFrames) {
  const auto read_at = [](double time) {
    return absolute_odometry(kStart + time, {7 + time, 0, 0});
  };
  const auto moved = [] { return motion_2d({2, 0, 0}, 0.1); };
  const Between read =
      between_of({frame({observation(kStart)}), read_at(0), read_at(1), read_at(2), moved(),
                  frame({observation(kStart + 2)}), moved(), frame({observation(kStart + 4)}),
                  read_at(4.5), moved(), frame({observation(kStart + 6)}), read_at(6), read_at(7)});
  ASSERT_EQ(read.steps.size(), 4U);
  EXPECT_EQ(read.steps[1], (Rows{{1, -1}, {2, 0}}));
  EXPECT_EQ(read.steps[2], (Rows{{4, 0}})) << "none between";
  EXPECT_EQ(read.steps[3], (Rows{{6, 0}})) << "no reading of the time of a frame";
  EXPECT_EQ(read.rest, (Rows{{7, 1}}));
}

}  // namespace
}  // namespace hybrid
