// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, the hybrid mapping authors

#include "mrpt_plugins/evaluation/graph_truth.h"

#include <gtest/gtest.h>

#include <string>

#include "libhybrid/core/error.h"
#include "tests/support/scratch_folder.h"

namespace hybrid {
namespace {

class GraphTruth : public ScratchFolder {
 protected:
  const std::vector<Key> poses = {Key('x', 0), Key('x', 1), Key('x', 2), Key('x', 3)};
};

TEST_F(GraphTruth, InterpolatesByTime) {
  const std::string truth = write("t.csv",
                                  "# time, x, y, angle\n0.0, 0, 0, 3.0\n1.0, 2, 4, -3.0\n"
                                  "9.0, 0, 0, 0\n");
  const std::string times = write("times.txt", "0.25\n1.0\n5.0\n9.5\n");
  const auto known = read_true_poses(truth, times, poses);
  ASSERT_EQ(known.size(), 2u);  // the third lies in a gap of 8 s, the fourth behind the end
  const auto& pose = known.at(poses[0]);
  EXPECT_NEAR(pose.x(), 0.5, 1e-12);
  EXPECT_NEAR(pose.y(), 1.0, 1e-12);
  EXPECT_NEAR(pose.yaw(), 3.0 + 0.25 * (2 * M_PI - 6.0), 1e-12);  // across pi
  EXPECT_NEAR(known.at(poses[1]).yaw(), -3.0, 1e-12);
}

TEST_F(GraphTruth, ReadsRowsOfAllPoses) {
  const auto known = read_true_poses(write("t.txt", "0 0 0\n1 0 0\n2 0 0.5\n3 0 0\n"), "", poses);
  ASSERT_EQ(known.size(), 4u);
  EXPECT_NEAR(known.at(poses[2]).x(), 2.0, 1e-12);
  EXPECT_NEAR(known.at(poses[2]).yaw(), 0.5, 1e-12);
}

TEST_F(GraphTruth, SaysWhatIsWrong) {
  const std::string times = write("times.txt", "0\n1\n2\n3\n");
  const auto expect_error = [&](const std::string& truth, const std::string& at_times,
                                const std::string& part) {
    try {
      read_true_poses(truth, at_times, poses);
      ADD_FAILURE() << "no error: " << part;
    } catch (const Error& e) {
      EXPECT_NE(std::string(e.what()).find(part), std::string::npos) << e.what();
    }
  };
  expect_error(write("a.csv", "0 0 0 0\n1 0 0\n"), times, "a.csv:2");
  expect_error(write("b.csv", "1 0 0 0\n0 0 0 0\n"), times, "b.csv:2:1: times must rise");
  expect_error(write("c.csv", ""), times, "no row");
  expect_error(write("d.csv", "100 0 0 0\n101 0 0 0\n"), times, "no true pose");
  expect_error(write("e.csv", "0 0 0 0\n1 0 0 0\n"), write("few.txt", "0\n1\n"), "2 times");
  expect_error((folder / "absent").string(), times, "absent");
  expect_error(write("f.txt", "0 0 0\n"), "", "has 1 poses, the graph 4");
}

}  // namespace
}  // namespace hybrid
