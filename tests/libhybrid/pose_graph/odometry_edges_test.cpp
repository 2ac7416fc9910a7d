// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, the hybrid mapping authors
#include <gtest/gtest.h>

#include "libhybrid/core/key_letters.h"
#include "libhybrid/geometry/se2.h"
#include "libhybrid/pose_graph/pose_graph.h"
#include "libhybrid/pose_graph/vertex_id.h"

namespace hybrid {
namespace {

/// The pose of a number of one robot, as GTSAM's Symbol has it.
Key symbol(char robot, std::uint64_t number) {
  const auto id = static_cast<std::uint64_t>(static_cast<unsigned char>(robot)) << 56U | number;
  return {key_letter::kPose, *vertex_index(static_cast<std::int64_t>(id))};
}

TEST(OdometryEdges, SkipNumbersButNotRobots) {
  PoseGraph graph;
  for (const char robot : {'a', 'b'}) {
    for (std::uint64_t i = 0; i < 20; i += 2) graph.values.insert(symbol(robot, i), SE2());
  }
  const OdometryEdges is_odometry(graph);
  EXPECT_TRUE(is_odometry(symbol('a', 4), symbol('a', 6)));
  EXPECT_TRUE(is_odometry(symbol('b', 6), symbol('b', 4)));
  EXPECT_FALSE(is_odometry(symbol('a', 4), symbol('a', 8)));
  EXPECT_FALSE(is_odometry(symbol('a', 18), symbol('b', 0)));
}

TEST(OdometryEdges, PlainNumbersMaySkipAsFarAsTheyLike) {
  PoseGraph graph;
  for (const std::uint64_t i : {0, 1, 5, 1000}) {
    graph.values.insert(Key(key_letter::kPose, i), SE2());
  }
  const OdometryEdges is_odometry(graph);
  EXPECT_TRUE(is_odometry(Key(key_letter::kPose, 1), Key(key_letter::kPose, 5)));
  EXPECT_TRUE(is_odometry(Key(key_letter::kPose, 5), Key(key_letter::kPose, 1000)));
  EXPECT_FALSE(is_odometry(Key(key_letter::kPose, 0), Key(key_letter::kPose, 5)));
}

}  // namespace
}  // namespace hybrid
