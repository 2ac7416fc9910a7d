// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, the hybrid mapping authors
#include "libhybrid/pose_graph/pose_graph.h"

#include <gtest/gtest.h>

#include <filesystem>
#include <string>

#include "libhybrid/factors/expect_jacobians.h"
#include "libhybrid/factors/sighted_point.h"
#include "libhybrid/io/read_graph.h"
#include "libhybrid/io/write_graph.h"
#include "tests/support/random.h"

namespace hybrid {
namespace {

using testing::Random;

Key x(int i) {
  return {'x', static_cast<std::uint64_t>(i)};
}
Key l(int i) {
  return {'l', static_cast<std::uint64_t>(i)};
}

/// Exact measurements among n poses: odometry without the step from `gap`, a loop over it, and
/// landmarks l0 .. l2 whose indices poses have too.
template <class Pose>
PoseGraph make_graph(int n, int gap, Values& truth, Random& random) {
  using Point = typename Pose::Point;
  PoseGraph graph;
  std::vector<GraphEdge<Pose>> edges;
  std::vector<GraphEdge<Point>> sightings;
  for (int i = 0; i < n; ++i) truth.insert(x(i), random.value<Pose>());
  for (int i = 0; i < 3; ++i) truth.insert(l(i), random.value<Point>());
  const auto add = [&](int i, int j) {
    edges.push_back({x(i), x(j), truth.at<Pose>(x(i)).inverse() * truth.at<Pose>(x(j)),
                     random.noise(Pose::kDim, 0.1)});
  };
  add(n - 1, 0);
  for (int i = 0; i + 1 < n; ++i) {
    if (i != gap) add(i, i + 1);
  }
  for (int i = 0; i < 3; ++i) {
    sightings.push_back({x(i), l(i), Point(truth.at<Pose>(x(i)).inverse() * truth.at<Point>(l(i))),
                         random.noise(Point::RowsAtCompileTime, 0.1)});
  }
  graph.values.insert(x(0), truth.at<Pose>(x(0)));
  if constexpr (Pose::kDim == 3) {
    graph.poses2 = edges;
    graph.points2 = sightings;
  } else {
    graph.poses3 = edges;
    graph.points3 = sightings;
  }
  return graph;
}

template <class Pose>
void check_start_from_odometry() {
  Random random{4};
  Values truth;
  const PoseGraph graph = make_graph<Pose>(10, 4, truth, random);
  const Values values = initialize_from_odometry(graph);
  EXPECT_EQ(values.size(), truth.size());
  const auto factors = to_factors(graph, values);
  EXPECT_EQ(factors.size(), graph.edge_count() + 1);
  for (const auto& factor : factors) {
    EXPECT_NEAR(factor->cost(truth), 0.0, 1e-12) << factor->name();
    EXPECT_NEAR(factor->cost(values), 0.0, 1e-12) << factor->name();
  }
  EXPECT_EQ(factors.back()->keys(), std::vector<Key>{x(0)});
}

TEST(InitializeFromOdometry, ReachesPosesBeyondAGap) {
  check_start_from_odometry<SE2>();
  check_start_from_odometry<SE3>();
}

TEST(InitializeFromOdometry, NamesDisconnectedVertices) {
  const PoseGraph graph = parse_graph(
      "EDGE_SE2 0 1 1 0 0 1 0 0 1 0 1\nEDGE_SE2 5 6 1 0 0 1 0 0 1 0 1\nVERTEX_SE2 9 0 0 0\n",
      "file");
  try {
    initialize_from_odometry(graph);
    FAIL() << "no error";
  } catch (const Error& error) {
    EXPECT_STREQ(error.what(), "no edge connects vertex 5, 6, 9 to vertex 0");
  }
}

TEST(InitializeFromOdometry, PlacesPartsWhereTheyAreMeasured) {
  const std::string ways = "EDGE_SE2 0 1 1 0 0 1 0 0 1 0 1\nEDGE_SE2 5 6 1 0 0 1 0 0 1 0 1\n";
  const std::string first = "EDGE_PRIOR_SE2 1 3 4 0 1 0 0 1 0 1\n";
  const std::string second = "EDGE_PRIOR_SE2_XY 5 0 9 1 0 1\nEDGE_PRIOR_SE2_XY 6 0 10 1 0 1\n";
  const PoseGraph graph = parse_graph(ways + first + second, "test");
  for (const Values& values : {initialize_from_odometry(graph), initialize_from_tree(graph)}) {
    EXPECT_LT((values.at<SE2>(x(0)).translation() - Eigen::Vector2d(2, 4)).norm(), 1e-9);
    EXPECT_LT((values.at<SE2>(x(6)).translation() - Eigen::Vector2d(0, 10)).norm(), 1e-9);
  }
  // One position leaves the second part free, and the first one alone makes no common frame.
  for (const std::string& priors : {first + "EDGE_PRIOR_SE2_XY 5 0 9 1 0 1\n", first, second}) {
    EXPECT_THROW(initialize_from_odometry(parse_graph(ways + priors, "test")), Error) << priors;
  }
}

TEST(InitializeFromOdometry, PrefersOdometryToLoops) {
  const PoseGraph graph = parse_graph(
      "EDGE_SE2 0 2 9 9 0 1 0 0 1 0 1\nEDGE_SE2 0 1 1 0 0 1 0 0 1 0 1\n"
      "EDGE_SE2 1 2 1 0 0 1 0 0 1 0 1\nEDGE_SE2 1 2 5 0 0 1 0 0 1 0 1\n",
      "file");
  const SE2 last = initialize_from_odometry(graph).at<SE2>(x(2));
  EXPECT_DOUBLE_EQ(last.x(), 2.0);
  EXPECT_DOUBLE_EQ(last.y(), 0.0);
}

TEST(ToFactors, AnchorsWhatIsFixed) {
  const PoseGraph graph = parse_graph(
      "VERTEX_SE2 0 0 0 0\nVERTEX_SE2 1 1 0 0\nVERTEX_XY 2 1 0\nFIX 1 2\n"
      "EDGE_SE2 0 1 1 0 0 1 0 0 1 0 1\n",
      "file");
  GraphFactorOptions options;
  options.planar_logarithm = true;
  const auto factors = to_factors(graph, graph.values, options);
  ASSERT_EQ(factors.size(), 3u);
  EXPECT_EQ(factors[1]->keys(), std::vector<Key>{x(1)});
  EXPECT_EQ(factors[2]->keys(), std::vector<Key>{l(2)});
}

TEST(ToFactors, WhatIsFixedStandsAtItsLine) {
  const std::string edges = "EDGE_SE2 0 1 1 0 0 1 0 0 1 0 1\nEDGE_SE2 1 2 1 0 0 1 0 0 1 0 1\n";
  const std::string line = "VERTEX_SE2 1 5 7 1\nFIX 1\n";
  // A pose measured in the map is not as sure as what is fixed.
  for (const std::string prior : {"", "EDGE_PRIOR_SE2 2 3 0 0 1 0 0 1 0 1\n"}) {
    const PoseGraph graph = parse_graph(edges + line + prior, "file");
    for (const Values& values : {initialize_from_odometry(graph), initialize_from_tree(graph)}) {
      const SE2& pose = values.at<SE2>(x(1));
      EXPECT_LT((pose.translation() - Eigen::Vector2d(5, 7)).norm(), 1e-12) << prior;
      EXPECT_NEAR(pose.angle(), 1, 1e-12);
    }
    Values elsewhere = initialize_from_odometry(graph);
    elsewhere.update(x(1), SE2());
    EXPECT_NEAR(to_factors(graph, elsewhere).back()->cost(graph.values), 0.0, 1e-12) << prior;
  }
}

template <class Pose>
void check_round_trip() {
  Random random{5};
  Values truth;
  PoseGraph graph = make_graph<Pose>(6, 2, truth, random);
  graph.values = truth;
  graph.fixed = {x(0), l(2)};
  const PoseGraph again = parse_graph(to_g2o(graph), "written");
  // Landmarks moved behind the last pose, whose ids they shared.
  EXPECT_EQ(again.fixed, (std::vector<Key>{x(0), l(8)}));
  for (int i = 0; i < 6; ++i) {
    EXPECT_TRUE(
        again.values.at<Pose>(x(i)).matrix().isApprox(truth.at<Pose>(x(i)).matrix(), 1e-14));
  }
  for (int i = 0; i < 3; ++i) {
    using Point = typename Pose::Point;
    EXPECT_EQ(again.values.at<Point>(l(6 + i)), truth.at<Point>(l(i))) << "not one bit differs";
  }
  const auto before = to_factors(graph, graph.values);
  const auto after = to_factors(again, again.values);
  ASSERT_EQ(before.size(), after.size());
  Values moved = truth, moved_again = again.values;
  moved.update(x(1), random.value<Pose>());
  moved_again.update(x(1), moved.at<Pose>(x(1)));
  for (std::size_t i = 0; i < before.size(); ++i) {
    EXPECT_NEAR(after[i]->cost(moved_again), before[i]->cost(moved),
                1e-9 * (1.0 + before[i]->cost(moved)));
  }
}

TEST(WriteG2o, ReadsBackTheSame) {
  check_round_trip<SE2>();
  check_round_trip<SE3>();
}

TEST(WriteG2o, LeavesNothingHalfWritten) {
  const std::string directory = ::testing::TempDir() + "write_g2o_test";
  std::filesystem::remove_all(directory);
  const PoseGraph graph = parse_graph("VERTEX_SE2 0 0 0 0\n", "file");
  EXPECT_THROW(write_g2o(directory + "/graph.g2o", graph), Error);
  std::filesystem::create_directory(directory);
  write_g2o(directory + "/graph.g2o", graph);
  EXPECT_EQ(read_graph(directory + "/graph.g2o").values.size(), 1u);
  std::filesystem::create_directories(directory + "/taken/inside");
  EXPECT_THROW(write_g2o(directory + "/taken", graph), Error);
  std::size_t files = 0;
  for (const auto& entry : std::filesystem::directory_iterator(directory)) {
    files += entry.is_regular_file();
  }
  EXPECT_EQ(files, 1u);
  std::filesystem::remove_all(directory);
}

TEST(WriteG2o, RefusesVariablesItCannotName) {
  PoseGraph graph;
  graph.values.insert(Key('b', 0), Eigen::Vector3d(1, 2, 3));
  EXPECT_THROW(to_g2o(graph), Error);
}

TEST(WriteG2o, DoesNotLoseALeverArm) {
  PoseGraph graph = parse_graph("VERTEX_SE2 7 0 0 0\nEDGE_PRIOR_SE2_XY 7 1 2 4 0 4\n", "file");
  EXPECT_EQ(parse_graph(to_g2o(graph), "again").positions2.size(), 1u);
  graph.positions2[0].lever_arm = {2, 0};
  EXPECT_THROW(to_g2o(graph), Error);
}

template <class Pose>
void check_sighted_point() {
  Random random{6};
  for (int trial = 0; trial < 10; ++trial) {
    Values values;
    values.insert(x(0), random.value<Pose>());
    values.insert(l(0), random.value<typename Pose::Point>());
    const SightedPoint<Pose> factor(x(0), l(0), random.value<typename Pose::Point>(),
                                    random.noise(Pose::Point::RowsAtCompileTime));
    testing::expect_jacobians(factor, values, 1e-6);
  }
}

TEST(SightedPoint, Jacobians) {
  check_sighted_point<SE2>();
  check_sighted_point<SE3>();
}

}  // namespace
}  // namespace hybrid
