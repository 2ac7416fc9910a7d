// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, the hybrid mapping authors
#include <gtest/gtest.h>

#include <string>
#include <vector>

#include "libhybrid/core/error.h"
#include "libhybrid/hybrid/graph.h"
#include "libhybrid/io/read_graph.h"
#include "libhybrid/io/write_graph.h"
#include "libhybrid/pose_graph/pose_graph.h"
#include "libhybrid/pose_graph/vertex_id.h"
#include "libhybrid/solvers/levenberg_marquardt.h"

namespace hybrid {
namespace {

const std::string kPlanar = " 100 0 0 100 0 400\n";
const std::string kSpatial = " 100 0 0 0 0 0 100 0 0 0 0 100 0 0 0 400 0 0 400 0 400\n";
const std::string kPoint = " 100 0 0 100 0 100\n";

Key pose_key(std::uint64_t i) {
  return {'x', i};
}

/// The optimum from the initial values of odometry, and its cost.
struct Solved {
  Values values;
  double cost = 0.0;
};
Solved solved(const PoseGraph& graph) {
  const Values initial = initialize_from_odometry(graph);
  HybridGraph factors;
  for (const auto& factor : to_factors(graph, initial)) factors.add(factor);
  const SolverResult result = levenberg_marquardt(factors, {initial, {}});
  return {result.values, result.report.final_cost()};
}

TEST(GraphConventions, MeasurementsOfASensorWithAnOffsetAreThoseOfTheRobot) {
  const std::string edges = "EDGE_SE3:QUAT 0 1 1 0 0 0 0 0 1" + kSpatial +
                            "EDGE_SE3_TRACKXYZ 0 7 3 1.2 2 -0.1" + kPoint +
                            "EDGE_SE3_TRACKXYZ 1 7 3 0.2 2 -0.1" + kPoint;
  const std::string offset = "PARAMS_SE3OFFSET 3 0.2 0 0.1 0 0 0 1\n";
  for (const std::string& text : {offset + edges, edges + offset}) {
    const Solved result = solved(parse_graph(text, "file"));
    EXPECT_NEAR(result.cost, 0.0, 1e-12);
    EXPECT_TRUE(
        result.values.at<Eigen::Vector3d>(Key('l', 7)).isApprox(Eigen::Vector3d(1.4, 2, 0), 1e-6));
  }
  try {
    parse_graph("PARAMS_SE3OFFSET 2 0.2 0 0.1 0 0 0 1\n" + edges, "file");
    FAIL();
  } catch (const Error& e) {
    EXPECT_NE(std::string(e.what()).find("sensor offset 3"), std::string::npos) << e.what();
  }
}

TEST(GraphConventions, AnOffsetThatTurnsTurnsTheNoise) {
  // A sensor that looks to the left knows the depth, which is the robot's y, ten times better.
  const PoseGraph graph = parse_graph(
      "PARAMS_SE3OFFSET 0 0 0 0 0 0 0.70710678118654757 0.70710678118654757\n"
      "EDGE_SE3_TRACKXYZ 0 7 0 2 0 0 10000 0 0 100 0 100\n",
      "file");
  EXPECT_TRUE(graph.points3[0].measured.isApprox(Eigen::Vector3d(0, 2, 0), 1e-9));
  const Eigen::Matrix3d information = graph.points3[0].noise.information();
  EXPECT_NEAR(information(0, 0), 100, 1e-6);
  EXPECT_NEAR(information(1, 1), 10000, 1e-4);
}

TEST(GraphConventions, PosesMeasuredInTheMapHoldIt) {
  // Odometry 5 % long and turned away; the priors say where the poses are.
  std::string text;
  for (int i = 0; i < 4; ++i) {
    const std::string id = std::to_string(i), x = std::to_string(i);
    text += "EDGE_SE3_PRIOR " + id + " 0 " + x +
            " 5 0 0 0 0 1 10000 0 0 0 0 0 10000 0 0 0 0 10000" + " 0 0 0 10000 0 0 10000 0 10000\n";
    if (i > 0) {
      text += "EDGE_SE3:QUAT " + std::to_string(i - 1) + " " + id + " 1.05 0 0 0 0 0 1" + kSpatial;
    }
  }
  const Solved result = solved(parse_graph(text, "file"));
  for (int i = 0; i < 4; ++i) {
    const SE3 x = result.values.at<SE3>(pose_key(std::uint64_t(i)));
    EXPECT_NEAR(x.translation().x(), i, 0.01);
    EXPECT_NEAR(x.translation().y(), 5, 0.01);
  }
}

TEST(GraphConventions, AMeasuredPoseOfASensorIsThatOfTheRobotBehindIt) {
  const PoseGraph graph = parse_graph(
      "PARAMS_SE3OFFSET 4 1 0 0 0 0 0.70710678118654757 0.70710678118654757\n"
      "EDGE_SE3_PRIOR 0 4 3 2 0 0 0 0.70710678118654757 0.70710678118654757" +
          kSpatial,
      "file");
  EXPECT_NEAR((graph.priors3[0].measured.translation() - Eigen::Vector3d(2, 2, 0)).norm(), 0, 1e-9);
  EXPECT_NEAR(graph.priors3[0].measured.rotation().log().norm(), 0.0, 1e-9);
  // A turn of the robot moves the sensor by its distance, to the robot's left.
  const Eigen::MatrixXd information = graph.priors3[0].noise.information();
  EXPECT_NEAR(information(5, 5), 400 + 100, 1e-6);
}

TEST(GraphConventions, PositionsAloneHoldTheMap) {
  std::string text;
  const std::vector<std::pair<double, double>> measured{{3, 1}, {3, 2}, {2, 2}};
  for (std::size_t i = 0; i < measured.size(); ++i) {
    text += "EDGE_PRIOR_SE2_XY " + std::to_string(i) + " " + std::to_string(measured[i].first) +
            " " + std::to_string(measured[i].second) + " 100 0 100\n";
  }
  text += "EDGE_SE2 0 1 1 0 1.5707963267948966" + kPlanar + "EDGE_SE2 1 2 1 0 0" + kPlanar;
  const Solved result = solved(parse_graph(text, "file"));
  EXPECT_NEAR(result.cost, 0.0, 1e-9);
  EXPECT_NEAR(result.values.at<SE2>(pose_key(0)).angle(), M_PI / 2, 1e-6);
}

TEST(GraphConventions, WhatIsMeasuredInTheMapIsWrittenAndReadBack) {
  const std::string text =
      "PARAMS_SE3OFFSET 0 0.1 0.2 0.3 0 0 0 1\n"
      "EDGE_SE3:QUAT 0 1 1 0 0 0 0 0 1" +
      kSpatial + "EDGE_SE3_PRIOR 0 0 1 2 3 0 0 0 1" + kSpatial + "EDGE_SE3_XYZPRIOR 1 0 1 2 3" +
      kPoint;
  const PoseGraph graph = parse_graph(text, "file");
  const PoseGraph back = parse_graph(to_g2o(graph), "back");
  ASSERT_EQ(back.prior_count(), 2u);
  EXPECT_TRUE(back.positions3[0].lever_arm.isApprox(Eigen::Vector3d(0.1, 0.2, 0.3), 1e-12));
  EXPECT_NEAR(solved(back).cost, solved(graph).cost, 1e-9);
  const PoseGraph plane =
      parse_graph("EDGE_SE2 0 1 1 0 0" + kPlanar + "EDGE_PRIOR_SE2 0 1 2 0.5" + kPlanar, "file");
  EXPECT_EQ(to_g2o(parse_graph(to_g2o(plane), "back")), to_g2o(plane));
}

TEST(GraphConventions, IdsOfGtsamKeepTheirOrderAndComeOutAsTheyWent) {
  const std::int64_t a0 = std::int64_t{'a'} << 56, labeled = std::int64_t{'a'} << 48;
  const std::int64_t both = a0 | std::int64_t{'B'} << 48;
  for (const std::int64_t first : {a0, labeled, both, std::int64_t{5}, kLargestPlainId - 1}) {
    EXPECT_EQ(vertex_id(*vertex_index(first)), static_cast<std::uint64_t>(first));
    EXPECT_EQ(*vertex_index(first) + 1, *vertex_index(first + 1));
    EXPECT_LT(*vertex_index(first), std::uint64_t{1} << 56);
  }
  EXPECT_FALSE(vertex_index(a0 | std::int64_t{1} << 41));
  std::string text;
  for (int i = 0; i < 3; ++i) {
    text += "EDGE_SE2 " + std::to_string(a0 + i) + " " + std::to_string(a0 + i + 1) + " 1 0 0" +
            kPlanar;
  }
  const PoseGraph graph = parse_graph(text, "file");
  const OdometryEdges is_odometry(graph);
  for (const auto& edge : graph.poses2) EXPECT_TRUE(is_odometry(edge.from, edge.to));
  const std::string back = to_g2o(graph);
  EXPECT_NE(back.find("EDGE_SE2 6989586621679009792 6989586621679009793 1"), std::string::npos)
      << back;
}

TEST(GraphConventions, PosesAndLandmarksMayShareNumbers) {
  const PoseGraph graph = parse_graph(
      "VERTEX_SE2 0 0 0 0\nVERTEX_SE2 1 1 0 0\nVERTEX_XY 0 1.4 2\nFIX 0\n"
      "EDGE_SE2 0 1 1 0 0" +
          kPlanar +
          "EDGE_SE2_XY 0 0 1.4 2 100 0 100\n"
          "EDGE_SE2_XY 1 0 0.4 2 100 0 100\n",
      "file");
  EXPECT_EQ(graph.fixed, std::vector<Key>{pose_key(0)});
  const Solved result = solved(graph);
  EXPECT_NEAR(result.cost, 0.0, 1e-12);
  EXPECT_TRUE(result.values.at<Eigen::Vector2d>(Key('l', 0)).isApprox(Eigen::Vector2d(1.4, 2)));
}

TEST(GraphConventions, InformationOfEdge2IsByRowsWhereOnlyThatIsDefinite) {
  const std::string edges =
      "EDGE2 0 1 1 0 0 400 0 0 400 0 2500\nEDGE2 1 2 1 0 0 400 0 0 300 0 2500\n";
  const PoseGraph rows = parse_graph(edges, "file");
  EXPECT_TRUE(rows.edge2_by_rows);
  EXPECT_NEAR(rows.poses2[1].noise.information()(1, 1), 300, 1e-9);
  EXPECT_NEAR(rows.poses2[1].noise.information()(2, 2), 2500, 1e-9);
  const PoseGraph toro = parse_graph("EDGE2 0 1 1 0 0 400 0 300 2500 0 0\n", "file");
  EXPECT_FALSE(toro.edge2_by_rows);
  EXPECT_NEAR(toro.poses2[0].noise.information()(2, 2), 2500, 1e-9);
  // Neither: an error as before.
  EXPECT_THROW(parse_graph(edges + "EDGE2 2 3 1 0 0 -1 0 0 1 0 1\n", "file"), InformationError);
}

TEST(GraphConventions, SeveralFixedVerticesAreWhereTheirLinesSay) {
  const PoseGraph graph = parse_graph(
      "VERTEX_SE2 0 0 0 0\nVERTEX_SE2 2 2.2 0 0\nFIX 0 2\n"
      "EDGE_SE2 0 1 1 0 0" +
          kPlanar + "EDGE_SE2 1 2 1 0 0" + kPlanar,
      "file");
  const Solved result = solved(graph);
  EXPECT_NEAR(result.values.at<SE2>(pose_key(2)).x(), 2.2, 1e-3);
  EXPECT_NEAR(result.values.at<SE2>(pose_key(1)).x(), 1.1, 1e-3);
}

TEST(GraphConventions, OdometryRunsInEitherDirectionAndAcrossMissingIds) {
  const PoseGraph graph =
      parse_graph("EDGE_SE2 4 1 -1 0 0" + kPlanar + "EDGE_SE2 4 7 1 0 0" + kPlanar +
                      "EDGE_SE2 1 7 2 0 0" + kPlanar + "EDGE_SE2 8 7 -1 0 0" + kPlanar,
                  "file");
  const OdometryEdges is_odometry(graph);
  std::vector<bool> odometry;
  for (const auto& edge : graph.poses2) odometry.push_back(is_odometry(edge.from, edge.to));
  EXPECT_EQ(odometry, (std::vector<bool>{true, true, false, true}));
  EXPECT_NEAR(initialize_from_odometry(graph).at<SE2>(pose_key(8)).x(), 3.0, 1e-12);
}

TEST(GraphConventions, ALandmarkThatNothingMeasuresIsLeftOutAndCounted) {
  const PoseGraph graph = parse_graph("VERTEX_XY 9 1 1\nEDGE_SE2 0 1 1 0 0" + kPlanar, "file");
  EXPECT_EQ(graph.unseen, 1u);
  EXPECT_FALSE(graph.values.contains(Key('l', 9)));
  EXPECT_NO_THROW(initialize_from_odometry(graph));
}

}  // namespace
}  // namespace hybrid
