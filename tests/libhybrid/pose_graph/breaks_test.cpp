// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, the hybrid mapping authors
#include "libhybrid/pose_graph/breaks.h"

#include <gtest/gtest.h>

#include <string>

#include "libhybrid/io/read_graph.h"

namespace hybrid {
namespace {

std::string edge(int i, int j, const std::string& information) {
  return "EDGE_SE2 " + std::to_string(i) + ' ' + std::to_string(j) + " 1 0 0 " + information + '\n';
}

/// Edges 0 1, 1 2, 2 3, 3 4 and 0 4; 1 2 and 0 4 have that information and the others another.
PoseGraph graph_with(const std::string& information, const std::string& other) {
  const std::string text = edge(0, 1, other) + edge(1, 2, information) + edge(2, 3, other) +
                           edge(3, 4, other) + edge(0, 4, information);
  return parse_graph(text, "test");
}

TEST(BoundBreaks, OdometryThatSaysNothingIsABreak) {
  const std::string usual = "400 0 0 400 0 10000";
  const std::vector<bool> with_break = {false, true, false, false, false};
  for (const std::string information :
       {"1e-12 0 0 1e-12 0 1e-12", "1e-300 0 0 1e-300 0 1e-300", "1e12 0 0 1e-12 0 1",
        "400 0 0 400 0 1e-6", "1e-5 0 0 1e-5 0 10000"}) {
    PoseGraph graph = graph_with(information, usual);
    const Noise loop = graph.poses2[4].noise;
    EXPECT_EQ(bound_breaks(graph), with_break) << information;
    const Eigen::MatrixXd bounded = graph.poses2[1].noise.information();
    EXPECT_GE(bounded.diagonal().head(2).minCoeff(), 0.9 / (50 * 50)) << information;
    EXPECT_GE(bounded(2, 2), 0.9 / (10 * 10)) << information;
    EXPECT_EQ(graph.poses2[4].noise.information(), loop.information());
  }
}

TEST(BoundBreaks, WhatIsOnlyPoorIsNone) {
  for (const auto& [information, other] :
       {std::pair("4 0 0 4 0 1", "400 0 0 400 0 10000"),
        std::pair("1 0 0 1 0 0.05", "400 0 0 400 0 10000"),        // little, yet something
        std::pair("400 0 0 400 0 10000", "1e12 0 0 1e12 0 1e14"),  // others stand still
        std::pair("1e-12 0 0 1e-12 0 1e-12", "1e-12 0 0 1e-12 0 1e-12"),
        std::pair("1 0 0 1 0 1", "1e-300 0 0 1e-300 0 1e-300"),
        std::pair("1e20 0 0 1e20 0 1e20", "400 0 0 400 0 10000")}) {
    PoseGraph graph = graph_with(information, other);
    const Eigen::MatrixXd stated = graph.poses2[1].noise.information();
    EXPECT_EQ(bound_breaks(graph), std::vector<bool>(5, false)) << information;
    EXPECT_EQ(graph.poses2[1].noise.information(), stated);
  }
}

}  // namespace
}  // namespace hybrid
