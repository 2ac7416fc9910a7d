// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, the hybrid mapping authors
#include <gtest/gtest.h>

#include <cmath>

#include "libhybrid/factors/bearing_range.h"
#include "libhybrid/factors/between.h"
#include "libhybrid/factors/prior.h"
#include "libhybrid/hybrid/mixture.h"
#include "libhybrid/io/read_graph.h"
#include "libhybrid/io/write_graph.h"
#include "libhybrid/pose_graph/pose_graph.h"

namespace hybrid {
namespace {

const Key kX0{'x', 0};
const Key kX1{'x', 1};
const Key kL0{'l', 0};
const DiscreteKey kLoop{{'d', 0}, 2};

TEST(ToPoseGraph, HoldsChosenMeasurements) {
  HybridGraph graph;
  Estimate estimate;
  estimate.values.insert(kX1, SE2(1.0, 0.0, 0.1));
  estimate.values.insert(kX0, SE2());
  estimate.values.insert(kL0, Eigen::Vector2d(2.0, 1.0));
  estimate.values.insert(Key('b', 0), Eigen::Vector3d(1.0, 2.0, 3.0));
  const Noise noise = Noise::isotropic(3, 0.1);
  graph.emplace<Prior<SE2>>(kX0, SE2(), noise);
  graph.emplace<BetweenSE2>(kX0, kX1, SE2(1.0, 0.0, 0.0), noise);
  graph.emplace<BearingRange2>(kX0, kL0, Eigen::Vector2d(2.0, std::acos(0.0)),
                               Noise::diagonal(Eigen::Vector2d(0.1, 0.01)), SE2(0.5, 0.0, 0.0));
  const auto loop = std::make_shared<Between<SE2>>(kX1, kX0, SE2(-1.0, 0.0, 0.0), noise);
  const auto wide =
      std::make_shared<Between<SE2>>(kX1, kX0, SE2(-1.0, 0.0, 0.0), noise.inflated(1e7));
  graph.add(make_outlier_mixture(kLoop, loop, wide, 0.5, 0.5));

  estimate.assignment.set(kLoop.key, 0);
  const PoseGraph accepted = to_pose_graph(graph, estimate);
  EXPECT_EQ(accepted.values.size(), 3u) << "the bias has no place in g2o";
  EXPECT_EQ(accepted.fixed, std::vector<Key>{kX0});
  EXPECT_EQ(accepted.poses2.size(), 2u);
  ASSERT_EQ(accepted.points2.size(), 1u);
  EXPECT_TRUE(accepted.points2[0].measured.isApprox(Eigen::Vector2d(0.5, 2.0), 1e-12));
  // Across the ray 2 m times 0.01 rad, along it 0.1 m.
  EXPECT_NEAR(accepted.points2[0].noise.covariance()(0, 0), 4e-4, 1e-12);
  EXPECT_NEAR(accepted.points2[0].noise.covariance()(1, 1), 1e-2, 1e-12);
  const PoseGraph read = parse_graph(to_g2o(accepted), "written");
  EXPECT_EQ(read.edge_count(), 3u);

  estimate.assignment.set(kLoop.key, 1);
  EXPECT_EQ(to_pose_graph(graph, estimate).poses2.size(), 1u);
}

TEST(ToPoseGraph, LeavesOutPointsAtTheSensor) {
  HybridGraph graph;
  Estimate estimate;
  estimate.values.insert(kX0, SE3());
  estimate.values.insert(kL0, Eigen::Vector3d(0.0, 0.0, 0.0));
  graph.emplace<BearingRange3>(kX0, kL0, Eigen::Vector3d::Zero(), Noise::unit(3));
  EXPECT_EQ(to_pose_graph(graph, estimate).edge_count(), 0u);
}

}  // namespace
}  // namespace hybrid
