// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, the hybrid mapping authors
#include "mrpt_plugins/output/graph_image.h"

#include <gtest/gtest.h>

namespace hybrid {
namespace {

int pixels_of(const Image& image, Color color) {
  int count = 0;
  for (std::size_t i = 0; i < image.rgb.size(); i += 3) {
    count += image.rgb[i] == color.red && image.rgb[i + 1] == color.green &&
             image.rgb[i + 2] == color.blue;
  }
  return count;
}

TEST(GraphImage, ShowsClosuresApartFromOdometry) {
  const Color closure{213, 94, 0};
  GraphDrawing graph;
  graph.poses = {{0, 0, 0}, {1, 0, 0}, {1, 1, 0}};
  graph.odometry = {{graph.poses[0], graph.poses[1]}, {graph.poses[1], graph.poses[2]}};
  EXPECT_EQ(pixels_of(graph_image(graph), closure), 0);
  EXPECT_GT(pixels_of(graph_image(graph), palette::kEstimate), 500);
  graph.closures = {{graph.poses[2], graph.poses[0]}};
  EXPECT_GT(pixels_of(graph_image(graph), closure), 20);
}

}  // namespace
}  // namespace hybrid
