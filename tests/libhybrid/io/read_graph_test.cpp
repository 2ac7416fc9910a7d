// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, the hybrid mapping authors
#include "libhybrid/io/read_graph.h"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>
#include <random>
#include <string>
#include <utility>
#include <vector>

#include "libhybrid/pose_graph/vertex_id.h"

namespace hybrid {
namespace {

const std::string kEye6 = "1 0 0 0 0 0 1 0 0 0 0 1 0 0 0 1 0 0 1 0 1";

std::string error_of(const std::string& text) {
  try {
    parse_graph(text, "file");
  } catch (const Error& error) {
    return error.what();
  }
  return "no error";
}

TEST(ReadGraph, PlanarG2o) {
  const PoseGraph graph = parse_graph(
      "# a comment\r\n"
      "VERTEX_SE2 0 0 0 0\r\n"
      "\r\n"
      "  VERTEX_SE2\t7 1.5 -2 +3.0e-1   # behind\r\n"
      "VERTEX_XY 9 4 5\r\n"
      "FIX 0 9\r\n"
      "EDGE_SE2 0 7 1 2 0.5 10 1 2 20 3 30\r\n"
      "EDGE_SE2_XY 7 9 -1 -2 4 1 9",
      "file");
  EXPECT_EQ(graph.values.size(), 3u);
  EXPECT_DOUBLE_EQ(graph.values.at<SE2>(Key('x', 7)).angle(), 0.3);
  EXPECT_DOUBLE_EQ(graph.values.at<Eigen::Vector2d>(Key('l', 9)).y(), 5.0);
  EXPECT_EQ(graph.fixed, (std::vector<Key>{Key('x', 0), Key('l', 9)}));
  ASSERT_EQ(graph.poses2.size(), 1u);
  EXPECT_EQ(graph.poses2[0].from, Key('x', 0));
  EXPECT_EQ(graph.poses2[0].to, Key('x', 7));
  EXPECT_DOUBLE_EQ(graph.poses2[0].measured.y(), 2.0);
  Eigen::Matrix3d information;
  information << 10, 1, 2, 1, 20, 3, 2, 3, 30;
  EXPECT_TRUE(graph.poses2[0].noise.information().isApprox(information, 1e-12));
  ASSERT_EQ(graph.points2.size(), 1u);
  EXPECT_EQ(graph.points2[0].to, Key('l', 9));
  EXPECT_EQ(graph.edge_count(), 2u);
}

TEST(ReadGraph, ToroHasItsOwnOrderOfInformation) {
  const PoseGraph graph =
      parse_graph("VERTEX2 1 1 2 3\nVERTEX2 2 1 2 3\nEDGE2 1 2 1 2 0.5 10 1 20 30 2 3\n", "file");
  Eigen::Matrix3d information;
  information << 10, 1, 2, 1, 20, 3, 2, 3, 30;
  EXPECT_TRUE(graph.poses2[0].noise.information().isApprox(information, 1e-12));
}

TEST(ReadGraph, EveryEdgeHasItsOwnNoise) {
  // Also after one of another size, and after an equal one.
  const std::string a = " 4 0 0 4 0 9\n", b = " 4 0 0 4 0 16\n", point = " 4 0 4\n";
  const PoseGraph graph =
      parse_graph("EDGE_SE2 0 1 1 0 0" + a + "EDGE_SE2 1 2 1 0 0" + a + "EDGE_SE2_XY 1 7 1 0" +
                      point + "EDGE_SE2 2 3 1 0 0" + b + "EDGE_SE2_XY 2 7 1 0" + point +
                      "EDGE_SE2_XY 3 7 1 0 4 0 5\n" + "EDGE_SE2 3 4 1 0 0" + a,
                  "file");
  const auto last = [](const Noise& noise) {
    return noise.information()(noise.dim() - 1, noise.dim() - 1);
  };
  std::vector<double> poses, points;
  for (const auto& edge : graph.poses2) poses.push_back(last(edge.noise));
  for (const auto& edge : graph.points2)
    points.push_back(std::round(1e9 * last(edge.noise)) * 1e-9);
  EXPECT_EQ(poses, (std::vector<double>{9, 9, 16, 9}));
  EXPECT_EQ(points, (std::vector<double>{4, 4, 5}));
}

TEST(ReadGraph, VerticesMayHaveAnyNumber) {
  const std::string largest = std::to_string(kLargestPlainId);
  const PoseGraph graph = parse_graph("FIX 16777215 16777216 " + largest +
                                          "\nEDGE_SE2 16777215 16777216 1 0 0 1 0 0 1 0 1\n"
                                          "EDGE_SE2_XY 16777216 " +
                                          largest + " 1 0 1 0 1\n",
                                      "file");
  EXPECT_EQ(graph.fixed, (std::vector<Key>{Key('x', 16777215), Key('x', 16777216),
                                           Key('l', std::uint64_t(kLargestPlainId))}));
  EXPECT_NE(error_of("EDGE_SE2 0 1 1 0 0 1 0 0 1 0 1\nFIX 2\n").find("FIX names unknown vertex 2"),
            std::string::npos);
}

TEST(ReadGraph, SpatialG2oAndToroAgree) {
  const double h = std::sqrt(0.5);
  const std::string q = " 0 0 " + std::to_string(2.0 * h) + " " + std::to_string(2.0 * h);
  const PoseGraph g2o =
      parse_graph("PARAMS_SE3OFFSET 0 0 0 0 0 0 0 1\nVERTEX_SE3:QUAT 0 1 2 3" + q +
                      "\nEDGE_SE3:QUAT 0 1 1 2 3" + q + " " + kEye6 +
                      "\nVERTEX_TRACKXYZ 5 1 2 3\nEDGE_SE3_TRACKXYZ 0 5 0 1 2 3 1 0 0 1 0 1\n",
                  "file");
  const std::string yaw = std::to_string(std::acos(0.0));
  const PoseGraph toro = parse_graph(
      "VERTEX3 0 1 2 3 0 0 " + yaw + "\nEDGE3 0 1 1 2 3 0 0 " + yaw + " " + kEye6 + "\n", "file");
  const Key x0{'x', 0};
  EXPECT_TRUE(g2o.values.at<SE3>(x0).matrix().isApprox(toro.values.at<SE3>(x0).matrix(), 1e-6));
  EXPECT_TRUE(g2o.poses3[0].measured.matrix().isApprox(toro.poses3[0].measured.matrix(), 1e-6));
  EXPECT_NEAR(g2o.values.at<SE3>(x0).rotation().quaternion().norm(), 1.0, 1e-12);
  EXPECT_EQ(g2o.points3.size(), 1u);
}

TEST(ReadGraph, AnglesAreRollPitchYaw) {
  const PoseGraph toro = parse_graph("VERTEX3 0 0 0 0 0.1 0.2 0.3\n", "file");
  const Eigen::Matrix3d R = toro.values.at<SE3>(Key('x', 0)).rotation().matrix();
  EXPECT_NEAR(std::atan2(R(2, 1), R(2, 2)), 0.1, 1e-12);
  EXPECT_NEAR(-std::asin(R(2, 0)), 0.2, 1e-12);
  EXPECT_NEAR(std::atan2(R(1, 0), R(0, 0)), 0.3, 1e-12);
}

/// A second line that is wrong, and what its message must say.
class MalformedLine : public ::testing::TestWithParam<std::pair<std::string, std::string>> {};

TEST_P(MalformedLine, IsNamedByFileLineAndReason) {
  const auto& [line, reason] = GetParam();
  const std::string message = error_of("VERTEX_SE2 0 0 0 0\n" + line + "\nVERTEX_SE2 8 0 0 0\n");
  EXPECT_EQ(message.rfind("file:2:", 0), 0u) << message;
  EXPECT_NE(message.find(reason), std::string::npos) << message;
}

INSTANTIATE_TEST_SUITE_P(
    Kinds, MalformedLine,
    ::testing::Values(
        std::pair("EDGE_SE2_SWITCHABLE 0 1 2", "EDGE_SE2_SWITCHABLE"),
        std::pair("\x7f\x01garbage", "unknown tag"),
        std::pair("VERTEX_SE2", "1 column; expected: VERTEX_SE2 id x y angle"),
        std::pair("VERTEX_SE2 -1 0 0 0", "'-1'"), std::pair("VERTEX_SE2 1.5 0 0 0", "'1.5'"),
        std::pair("VERTEX_SE2 99999999999999999999 0 0 0", "99999999999999999999"),
        std::pair("VERTEX_SE2 1 0 0", "2:17: 4 columns; expected: VERTEX_SE2 id x y angle"),
        std::pair("VERTEX_SE2 1 0 0 0 0", "2:20: 6 columns"),
        std::pair("VERTEX_SE2 1 0 abc 0", "'abc' is not a number"),
        std::pair("VERTEX_SE2 1 0 1.5x 0", "'1.5x' is not a number"),
        std::pair("VERTEX_SE2 1 0 nan 0", "'nan' is not a finite number"),
        std::pair("VERTEX_SE2 1 0 -inf 0", "'-inf' is not a finite number"),
        std::pair("VERTEX_SE2 1 0 1e999 0", "'1e999' is not a finite number"),
        std::pair("VERTEX_SE2 1 0 1,5 0", "'1,5' is not a number; decimals are"),
        std::pair("VERTEX_SE2;1;0;0;0", "unknown tag"),
        std::pair("VERTEX_SE2 1 0 1e300 0", "2:16: '1e300' is beyond 1e15"),
        std::pair("EDGE_SE2 0 1 0 0 -1e16 1 0 0 1 0 1", "'-1e16' is beyond 1e15"),
        std::pair("VERTEX_SE2 0 1 1 1", "2:12: vertex 0 is there already"),
        std::pair("EDGE_SE2 3 3 0 0 0 1 0 0 1 0 1", "vertex 3 to itself"),
        std::pair("EDGE_SE2 0 1 0 0 0 1 0 0 1 0 -1", "positive definite"),
        std::pair("EDGE_SE2 0 1 0 0 0 0 0 0 0 0 0", "positive definite"),
        std::pair("EDGE_SE2 0 1 0 0 0 1e300 0 0 1e300 0 1", "2:1: information beyond 1e30"),
        std::pair("EDGE_SE2 0 1 0 0 0 1 0 0 1 0",
                  "11 columns; expected: EDGE_SE2 i j x y angle information(6)"),
        std::pair("EDGE2 0 1 0 0 0 1 5 1 1 0 0", "positive definite"),
        std::pair("EDGE_SE2 0", "2 columns"),
        std::pair("FIX 77", "2:5: FIX names unknown vertex 77"),
        std::pair("FIX", "expected: FIX id"), std::pair("FIX 0 q", "'q'"),
        std::pair("EQUIV 0", "2 columns"), std::pair("EQUIV 0 1 2", "expected: EQUIV i j"),
        std::pair("VERTEX_SE3:QUAT 1 0 0 0 0 0 0 1", "3-D line in a 2-D graph"),
        std::pair("VERTEX_SE3:QUAT 1 0 0 0 0 0 0 0", "quaternion"),
        std::pair("EDGE_SE3:QUAT 0 1 0 0 0 0 0 0 1e-9 " + kEye6, "quaternion"),
        std::pair("EDGE_SE2 0 9223372036854775807 0 0 0 1 0 0 1 0 1", "Symbol of GTSAM")));

// As at the end of GTSAM's w100.graph.
TEST(ReadGraph, CountsEquivalencesAndDoesNotApplyThem) {
  const std::string edge = "EDGE2 1 0 1 0 0 1 0 1 1 0 0\n";
  const PoseGraph graph = parse_graph(edge + "EQUIV 0 1\nEQUIV 5 6\n", "file");
  EXPECT_EQ(graph.equivalences, 2u);
  EXPECT_EQ(graph.poses2.size(), 1u);
  EXPECT_EQ(parse_graph(edge, "file").equivalences, 0u);
}

TEST(ReadGraph, RefusesWhatHoldsNoGraph) {
  EXPECT_EQ(error_of(""), "file: holds no vertex and no edge");
  EXPECT_EQ(error_of("# nothing\n\n"), "file: holds no vertex and no edge");
  EXPECT_THROW(read_graph("/no/such/file.g2o"), Error);
  EXPECT_THROW(read_graph("/"), Error);
}

// Damaged text gives a graph or an Error, nothing else.
TEST(ReadGraph, SurvivesRandomBytes) {
  const std::string original =
      "VERTEX_SE2 0 0 0 0\nVERTEX_SE2 1 1 0 0.1\nVERTEX_XY 2 4 5\nFIX 0\n"
      "EDGE_SE2 0 1 1 0 0.1 10 0 0 10 0 10\nEDGE2 1 0 1 0 0.1 10 0 10 10 0 0\n"
      "EDGE_SE2_XY 1 2 3 4 1 0 1\n";
  std::mt19937 rng(1);
  int errors = 0;
  for (int trial = 0; trial < 20000; ++trial) {
    std::string text = original;
    for (unsigned n = 1 + rng() % 4; n > 0; --n) {
      const std::size_t at = rng() % text.size();
      switch (rng() % 3) {
        case 0:
          text[at] = static_cast<char>(rng());
          break;
        case 1:
          text.erase(at, 1 + rng() % 10);
          break;
        default:
          text.insert(at, original.substr(rng() % original.size(), rng() % 20));
      }
    }
    try {
      parse_graph(text, "file");
    } catch (const Error&) {
      ++errors;
    }
  }
  EXPECT_GT(errors, 5000);
  EXPECT_LT(errors, 20000);
}

TEST(ReadGraph, RepairsInformationToTheNearestDefiniteMatrix) {
  const std::string text =
      "EDGE_SE2 0 1 1 0 0 4 0 0 9 0 16\n"
      "EDGE_SE2 1 2 1 0 0 4 0 0 9 0 -1\n"
      "EDGE_SE2 2 3 1 0 0 1 2 0 1 0 5\n"
      "EDGE_SE2_XY 2 7 1 0 1 1 1\n";
  EXPECT_THROW(parse_graph(text, "g"), InformationError);
  ReadGraphOptions repair;
  repair.repair_information = true;
  const PoseGraph graph = parse_graph(text, "g", repair);
  EXPECT_EQ(graph.repaired, 3u);
  EXPECT_TRUE(graph.poses2[0].noise.information().isApprox(
      Eigen::Matrix3d(Eigen::Vector3d(4, 9, 16).asDiagonal()), 1e-14));
  const double least = std::sqrt(std::numeric_limits<double>::epsilon());
  EXPECT_TRUE(graph.poses2[1].noise.information().isApprox(
      Eigen::Matrix3d(Eigen::Vector3d(4, 9, 9 * least).asDiagonal()), 1e-14));
  // Eigenvalues 3, -1 with (1, 1) and (1, -1): the nearest is 3/2 everywhere.
  EXPECT_NEAR(graph.poses2[2].noise.information()(0, 1), 1.5, 1e-6);
  EXPECT_NEAR(graph.points2[0].noise.information()(0, 0), 1.0, 1e-6);
  EXPECT_THROW(parse_graph("EDGE_SE2 0 1 0 0 0 0 0 0 0 0 0", "g", repair), InformationError);
  EXPECT_THROW(parse_graph("EDGE_SE2 0 1 0 0 0 nan 0 0 1 0 1", "g", repair), Error);
}

}  // namespace
}  // namespace hybrid
