// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, the hybrid mapping authors

#include "mrpt_plugins/output/graph_export.h"

#include <gtest/gtest.h>

#include "libhybrid/factors/bearing_range.h"
#include "libhybrid/factors/between.h"

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

}  // namespace
}  // namespace hybrid
