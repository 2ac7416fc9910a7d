// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, the hybrid mapping authors
#include <gtest/gtest.h>

#include <string>

#include "libhybrid/io/read_graph.h"
#include "libhybrid/pose_graph/pose_feed.h"
#include "libhybrid/pose_graph/pose_graph.h"

namespace hybrid {
namespace {

constexpr const char* kGraph =
    "EDGE2 0 1 1 0 1 1 0 0\n"
    "EDGE2 1 1 2 0 2 1 0 0 0.5 0.5 1\n"
    "EDGE2 2 1 3 0 3 1 0 0.1 2 0 0.2 3 0 0.3\n"
    "EDGE2 3 1 0 0 1 -3 0 0\n";

std::string error_of(const std::string& text) {
  try {
    parse_graph(text, "f.graph");
  } catch (const Error& e) {
    return e.what();
  }
  return "";
}

TEST(Hypotheses, AreReadBehindTheFirst) {
  const PoseGraph graph = parse_graph(kGraph, "f");
  ASSERT_EQ(graph.poses2.size(), 4u);
  ASSERT_EQ(graph.alternatives2.size(), 2u);
  EXPECT_EQ(graph.alternatives2[0].edge, 1u);
  ASSERT_EQ(graph.alternatives2[1].measured.size(), 2u);
  EXPECT_DOUBLE_EQ(graph.alternatives2[1].measured[1].x(), 3.0);
  EXPECT_NEAR(graph.poses2[0].noise.covariance()(0, 0), 1.0 / 900, 1e-12);
  EXPECT_NEAR(graph.poses2[0].noise.covariance()(2, 2), 1e-4, 1e-12);
}

TEST(Hypotheses, PlainTorosLinesStayWhatTheyWere) {
  const PoseGraph graph = parse_graph("EDGE2 0 1 1 0 2 1 0 1 1 0 0\n", "f");
  ASSERT_EQ(graph.poses2.size(), 1u);
  EXPECT_TRUE(graph.alternatives2.empty());
  EXPECT_EQ(graph.poses2[0].to, Key('x', 1));
}

TEST(Hypotheses, InSpace) {
  const PoseGraph graph = parse_graph(
      "EDGE3 0 1 1 0 1 1 0 0 0 0 0.5\n"
      "EDGE3 1 1 2 0 4 1 0 0 0 0 0 2 0 0 0 0 0 3 0 0 0.1 0 0 4 0 0 0 0.2 0\n",
      "f");
  ASSERT_EQ(graph.poses3.size(), 2u);
  EXPECT_NEAR(graph.poses3[0].measured.rotation().log()[2], 0.5, 1e-12);
  EXPECT_NEAR(graph.poses3[0].noise.covariance()(0, 0), 1.0 / 900, 1e-12);
  EXPECT_NEAR(graph.poses3[0].noise.covariance()(5, 5), 1e-4, 1e-12);
  ASSERT_EQ(graph.alternatives3.size(), 1u);
  EXPECT_EQ(graph.alternatives3[0].edge, 1u);
  ASSERT_EQ(graph.alternatives3[0].measured.size(), 3u);
  EXPECT_DOUBLE_EQ(graph.alternatives3[0].measured[1].translation()[0], 3.0);
  EXPECT_EQ(make_hypotheses(graph, 0)->discrete_keys()[0].cardinality, 4);
  EXPECT_THROW(make_hypotheses(graph, 1), Error);
}

TEST(Hypotheses, ErrorsNameTheLine) {
  const std::string good = "EDGE2 0 1 1 0 1 1 0 0\n";
  EXPECT_NE(error_of(good + "EDGE2 1 1 2 0 2 1 0 0\n").find("f.graph:2:"), std::string::npos);
  EXPECT_NE(error_of(good + "EDGE2 1 1 2 0 1 1 0 0 4\n").find("f.graph:2:"), std::string::npos);
  EXPECT_NE(error_of(good + "EDGE2 1 1 2 0 0\n").find("f.graph:2:"), std::string::npos);
  EXPECT_NE(error_of(good + "EDGE2 1 2 2 0 1 1 0 0\n").find("f.graph:2:"), std::string::npos);
  EXPECT_NE(error_of(good + "EDGE2 1 1 2 0 1 1 nan 0\n").find("f.graph:2:"), std::string::npos);
  EXPECT_EQ(error_of(good), "");
}

TEST(Hypotheses, ShuffleIsAPermutationThatTheSeedFixes) {
  const PoseGraph original = parse_graph(kGraph, "f");
  bool moved = false;
  for (std::uint64_t seed = 0; seed < 8; ++seed) {
    PoseGraph a = original, b = original;
    const std::vector<int> first = shuffle_hypotheses(a, seed);
    EXPECT_EQ(first, shuffle_hypotheses(b, seed));
    for (std::size_t k = 0; k < 2; ++k) {
      const EdgeAlternatives<SE2>& alternatives = a.alternatives2[k];
      const SE2 found = first[k] == 0 ? a.poses2[alternatives.edge].measured
                                      : alternatives.measured[first[k] - 1];
      EXPECT_EQ(found.x(), original.poses2[alternatives.edge].measured.x());
      EXPECT_EQ(found.angle(), original.poses2[alternatives.edge].measured.angle());
      moved = moved || first[k] != 0;
    }
  }
  EXPECT_TRUE(moved);
}

TEST(Hypotheses, ComeFromTheFeedAsMixtures) {
  const PoseGraph graph = parse_graph(kGraph, "f");
  PoseFeed feed(graph, initialize_from_odometry(graph));
  Values values;
  std::size_t mixtures = 0;
  while (!feed.done()) {
    const Delta delta = feed.next(values);
    for (Key key : delta.values.keys()) values.insert(key, delta.values.at<SE2>(key));
    for (const auto& factor : delta.hybrid) {
      EXPECT_EQ(factor->discrete_keys()[0].key, hypothesis_key(mixtures));
      ++mixtures;
    }
  }
  EXPECT_EQ(mixtures, 2u);
  EXPECT_THROW(make_hypotheses(graph, 2), Error);
}

}  // namespace
}  // namespace hybrid
