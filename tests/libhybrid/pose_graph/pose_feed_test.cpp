// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, the hybrid mapping authors
#include "libhybrid/pose_graph/pose_feed.h"

#include <gtest/gtest.h>

#include "libhybrid/core/error.h"
#include "libhybrid/io/read_graph.h"

namespace hybrid {
namespace {

constexpr const char* kInformation = " 1 0 0 1 0 1\n";

std::string edge(int i, int j, double x) {
  return "EDGE_SE2 " + std::to_string(i) + " " + std::to_string(j) + " " + std::to_string(x) +
         " 0 0" + kInformation;
}

TEST(PoseFeed, GivesEachPoseWithItsMeasurementsToEarlierOnes) {
  // Pose 1 waits for pose 2; the closure 0-3 stands before the odometry 2-3, which is preferred.
  const PoseGraph graph =
      parse_graph(edge(0, 2, 2) + edge(0, 3, 9) + edge(2, 3, 1) + edge(2, 1, -1) +
                      "EDGE_SE2_XY 3 7 1 1 1 0 1\n" + "EDGE_SE2_XY 2 7 2 1 1 0 1\n",
                  "test");
  PoseFeed feed(graph, initialize_from_odometry(graph));
  ASSERT_EQ(feed.steps(), 4u);
  std::vector<Key> order;
  std::vector<std::size_t> factors;
  Values estimate;
  while (!feed.done()) {
    order.push_back(feed.pose());
    const Delta delta = feed.next(estimate);
    factors.push_back(delta.continuous.size());
    EXPECT_TRUE(delta.values.contains(order.back()));
    for (Key key : delta.values.keys()) {
      estimate.insert(key, delta.values.type(key), delta.values.data(key));
    }
  }
  EXPECT_EQ(order, (std::vector<Key>{{'x', 0}, {'x', 2}, {'x', 1}, {'x', 3}}));
  EXPECT_EQ(factors, (std::vector<std::size_t>{1, 2, 1, 3}));
  EXPECT_NEAR(estimate.at<SE2>({'x', 1}).x(), 1.0, 1e-12);
  EXPECT_NEAR(estimate.at<SE2>({'x', 3}).x(), 3.0, 1e-12);
  EXPECT_NEAR(estimate.at<Eigen::Vector2d>({'l', 7}).x(), 4.0, 1e-12);
}

TEST(PoseFeed, NamesWhatIsNotConnected) {
  const PoseGraph graph = parse_graph(edge(0, 1, 1) + edge(4, 5, 1), "test");
  Values initial;
  for (std::uint64_t i : {0, 1, 4, 5}) initial.insert(Key{'x', i}, SE2());
  try {
    PoseFeed feed(graph, initial);
    FAIL();
  } catch (const Error& e) {
    EXPECT_NE(std::string(e.what()).find("vertex 4 to vertex 0 (2 such"), std::string::npos);
  }
}

/// Feeds a graph whole; returns how many poses each step adds, and the last pose of each.
std::vector<std::pair<std::size_t, std::uint64_t>> feed_all(PoseFeed feed) {
  std::vector<std::pair<std::size_t, std::uint64_t>> steps;
  Values estimate;
  while (!feed.done()) {
    const std::size_t before = feed.added();
    const Key pose = feed.pose();
    const Delta delta = feed.next(estimate);
    for (Key key : delta.values.keys()) {
      estimate.insert(key, delta.values.type(key), delta.values.data(key));
    }
    for (const auto& factor : delta.continuous) {
      for (Key key : factor->keys()) EXPECT_TRUE(estimate.contains(key));
    }
    steps.emplace_back(feed.added() - before, pose.index());
  }
  return steps;
}
using Steps = std::vector<std::pair<std::size_t, std::uint64_t>>;

TEST(PoseFeed, BeginsWithAsManyPosesAsPositionsNeed) {
  const std::string ways = edge(0, 1, 1) + edge(1, 2, 1) + edge(2, 3, 1);
  const auto position = [](int i, double at) {
    return "EDGE_PRIOR_SE2_XY " + std::to_string(i) + " " + std::to_string(at) + " 0 1 0 1\n";
  };
  const auto steps = [](const std::string& text) {
    const PoseGraph graph = parse_graph(text, "test");
    return feed_all(PoseFeed(graph, initialize_from_odometry(graph)));
  };
  EXPECT_EQ(steps(ways + position(0, 5) + position(1, 5) + position(2, 7)),
            (Steps{{3, 2}, {1, 3}}));
  EXPECT_EQ(steps(ways + position(0, 5) + position(3, 8)), (Steps{{4, 3}}));
  // A pose that is measured suffices.
  EXPECT_EQ(steps(ways + position(0, 5) + "EDGE_PRIOR_SE2 0 5 0 0" + kInformation),
            (Steps{{1, 0}, {1, 1}, {1, 2}, {1, 3}}));
}

TEST(PoseFeed, PartsThatAreMeasuredInTheMapFollowEachOther) {
  const PoseGraph graph = parse_graph(edge(0, 1, 1) + edge(5, 6, 1) + "EDGE_PRIOR_SE2 1 0 0 0" +
                                          kInformation + "EDGE_PRIOR_SE2 6 9 0 0" + kInformation,
                                      "test");
  EXPECT_EQ(feed_all(PoseFeed(graph, initialize_from_odometry(graph))),
            (Steps{{1, 1}, {1, 0}, {1, 6}, {1, 5}}));
}

TEST(PoseFeed, GoesAlongWhatConnects) {
  const PoseGraph graph =
      parse_graph(edge(0, 1, 1) + edge(1, 5, 9) + edge(5, 6, 1) + edge(0, 6, 3), "test");
  const Values initial = initialize_from_odometry(graph);
  EXPECT_EQ(feed_all(PoseFeed(graph, initial)), (Steps{{1, 0}, {1, 1}, {1, 5}, {1, 6}}));
  EXPECT_EQ(feed_all(PoseFeed(graph, initial, {}, [](std::size_t f) { return f != 1; })),
            (Steps{{1, 0}, {1, 1}, {1, 6}, {1, 5}}));
}

TEST(PoseFeed, PastItsEndIsAnError) {
  const PoseGraph graph = parse_graph("EDGE_SE2 0 1 1 0 0 1 0 0 1 0 1\n", "file");
  PoseFeed feed(graph, initialize_from_odometry(graph));
  while (!feed.done()) feed.next(initialize_from_odometry(graph));
  EXPECT_THROW(feed.pose(), Error);
  EXPECT_THROW(feed.next(Values()), Error);
  const PoseGraph none;
  const PoseFeed empty(none, Values());
  EXPECT_THROW(empty.pose(), Error);
}

}  // namespace
}  // namespace hybrid
