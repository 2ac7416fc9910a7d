// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, the hybrid mapping authors
#include "libhybrid/scans/scan_mapper.h"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>
#include <random>

#include "tests/support/scan_worlds.h"

namespace hybrid {
namespace {

struct RingRun {
  std::vector<SE2> path;
  std::size_t accepted = 0;
  double error = 0.0;  // root mean square, in the frame of the first pose [m]
};

RingRun map_ring(unsigned seed, bool with_odometry) {
  const testing::FloorPlan plan = testing::ring();
  const std::vector<SE2> way = testing::way_around_ring(2, 0.15);
  std::mt19937 random(seed);
  std::normal_distribution<double> noise;
  ScanMapper mapper;
  for (std::size_t i = 0; i < way.size(); ++i) {
    std::optional<SE2> odometry;
    if (with_odometry && i > 0) {
      const SE2 step = way[i - 1].between(way[i]);
      odometry = step * SE2(0.01 * noise(random), 0.005 * noise(random), 0.01 * noise(random));
    }
    mapper.add(plan.scan(way[i], 181, 0.015, random), odometry);
  }
  mapper.finish();
  RingRun run{mapper.path(), 0, 0.0};
  for (std::size_t i = 0; i < way.size(); ++i) {
    const SE2 truth = way.front().between(way[i]);
    run.error += (truth.translation() - run.path[i].translation()).squaredNorm();
  }
  run.error = std::sqrt(run.error / double(way.size()));
  for (std::size_t k = 0; k < mapper.closures().size(); ++k) {
    run.accepted += mapper.status(k) == ClosureStatus::kAccepted ? 1 : 0;
  }
  return run;
}

TEST(ScanMapper, ClosesTheLoopOfARing) {
  double worst = 0.0;
  for (unsigned seed = 0; seed < 3; ++seed) {
    const RingRun run = map_ring(seed, true);
    EXPECT_GT(run.accepted, 20u) << seed;
    worst = std::max(worst, run.error);
  }
  EXPECT_LT(worst, 0.15);
}

TEST(ScanMapper, MapsByScansAlone) {
  const RingRun run = map_ring(5, false);
  EXPECT_GT(run.accepted, 20u);
  EXPECT_LT(run.error, 0.25);
}

TEST(ScanMapper, DoesTheSameAgain) {
  const RingRun a = map_ring(2, true);
  const RingRun b = map_ring(2, true);
  ASSERT_EQ(a.path.size(), b.path.size());
  for (std::size_t i = 0; i < a.path.size(); ++i) {
    EXPECT_EQ(a.path[i].x(), b.path[i].x());
    EXPECT_EQ(a.path[i].angle(), b.path[i].angle());
  }
}

TEST(ScanMapper, NoScanAndBlindScansAreNoFault) {
  ScanMapper mapper;
  mapper.finish();
  EXPECT_TRUE(mapper.path().empty());
  LaserScan blind;
  blind.ranges.assign(10, std::numeric_limits<float>::quiet_NaN());
  for (int i = 0; i < 50; ++i) mapper.add(blind, SE2(0.2, 0, 0.01));
  mapper.finish();
  EXPECT_EQ(mapper.path().size(), 50u);
  EXPECT_TRUE(mapper.closures().empty());
}

}  // namespace
}  // namespace hybrid
