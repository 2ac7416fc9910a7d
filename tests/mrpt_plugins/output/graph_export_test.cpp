// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, the hybrid mapping authors

#include "mrpt_plugins/output/graph_export.h"

#include <gtest/gtest.h>

#include "libhybrid/factors/bearing_range.h"
#include "libhybrid/factors/between.h"
#include "libhybrid/factors/prior.h"
#include "libhybrid/io/write_graph.h"

namespace hybrid {
namespace {

TEST(ExportGraph, LeavesOutASightingWhosePlaceHasASingularCovariance) {
  HybridGraph graph;
  const Key x('x', 0), near('l', 0), far('l', 1);
  const Noise noise = Noise::isotropic(3, 0.01);
  Estimate estimate;
  estimate.values.insert(x, SE3());
  estimate.values.insert(near, Eigen::Vector3d(0, 0, 0));
  estimate.values.insert(far, Eigen::Vector3d(2, 0, 0));
  graph.emplace<BearingRange3>(x, near, Eigen::Vector3d(0, 0, 0), noise);
  graph.emplace<BearingRange3>(x, far, Eigen::Vector3d(2, 0, 0), noise);
  const ExportedGraph exported = export_graph(graph, estimate);
  ASSERT_EQ(exported.graph.points3.size(), 1U);
  EXPECT_EQ(exported.graph.points3[0].to, far);
  EXPECT_EQ(exported.left_out, std::vector<std::string>{"bearing-range"});
}

TEST(ExportGraph, LeavesOutVariablesOfAPluginAndTheirFactors) {
  HybridGraph graph;
  const Key x('x', 0), y('x', 1), walls('w', 0), gate('p', 0);
  const Noise noise = Noise::isotropic(3, 0.1);
  Estimate estimate;
  for (Key key : {x, y, gate}) estimate.values.insert(key, SE2());
  estimate.values.insert(walls, SO2(0.3));
  graph.emplace<Prior<SE2>>(x, SE2(), noise);
  graph.emplace<Prior<SE2>>(gate, SE2(), noise);
  graph.emplace<Prior<SO2>>(walls, SO2(0.3), Noise::isotropic(1, 0.1));
  graph.emplace<BetweenSE2>(x, y, SE2(), noise);
  graph.emplace<BetweenSE2>(y, gate, SE2(), noise);
  const ExportedGraph exported = export_graph(graph, estimate);
  EXPECT_EQ(exported.graph.values.keys(), (std::vector<Key>{x, y}));
  EXPECT_EQ(exported.graph.fixed, std::vector<Key>{x});
  EXPECT_EQ(exported.graph.poses2.size(), 1U);
  EXPECT_EQ(exported.left_out.size(), 2U);  // priors, relative poses
  EXPECT_EQ(to_g2o(exported.graph).substr(0, 10), "VERTEX_SE2");
}

}  // namespace
}  // namespace hybrid
