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
