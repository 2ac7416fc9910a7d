// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, the hybrid mapping authors
#include <gtest/gtest.h>

#include "libhybrid/io/read_graph.h"

namespace hybrid {
namespace {

std::string with(const std::string& information) {
  std::string text;
  for (const std::string ends : {"0 1", "1 2", "2 3"}) {
    text += "EDGE_SE2 " + ends + " 1 0 0 " + information + "\n";
  }
  return text;
}

TEST(EraseCopies, OfEdgesThatAreTheSameToTheLastBit) {
  const std::string closure = "EDGE_SE2 0 2 2 0 0 1 0 0 1 0 1\n";
  PoseGraph graph =
      parse_graph(with("1 0 0 1 0 1") + closure + closure + closure +
                      "EDGE_SE2 0 2 2 0 1e-9 1 0 0 1 0 1\n" + "EDGE_SE2 0 2 2 0 0 2 0 0 1 0 1\n" +
                      "EDGE_SE2_XY 0 9 1 1 1 0 1\nEDGE_SE2_XY 0 9 1 1 1 0 1\n",
                  "test");
  EXPECT_EQ(graph.poses2.size(), 8u);
  erase_copies(graph);
  EXPECT_EQ(graph.copies, 3u);
  EXPECT_EQ(graph.poses2.size(), 6u);
  EXPECT_EQ(graph.points2.size(), 1u);
  EXPECT_DOUBLE_EQ(graph.poses2[5].noise.information()(0, 0), 2.0);
}

TEST(IsInformationInverted, WhereSigmasSayLessThanNothing) {
  EXPECT_TRUE(is_information_inverted(parse_graph(with("0.0025 0 0 0.0025 0 0.0004"), "test")));
  for (const std::string information : {"400 0 0 400 0 2500", "1 0 0 1 0 1",
                                        "0.01 0 0 0.01 0 1",        // a poor way, a fair turn
                                        "100 0 0 100 0 0.0001"}) {  // the other way round
    EXPECT_FALSE(is_information_inverted(parse_graph(with(information), "test"))) << information;
  }
}

}  // namespace
}  // namespace hybrid
