// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, the hybrid mapping authors

#include "mrpt_plugins/evaluation/ground_truth.h"

#include <gtest/gtest.h>

#include <functional>

#include "libhybrid/core/error.h"
#include "tests/mrpt_plugins/input/log_files.h"

namespace hybrid {
namespace {

template <class Reader>
auto read_text(Reader reader, const std::string& text) {
  const TemporaryFile file("truth.txt");
  write_bytes(file.path(), text);
  return reader(file.path());
}

template <class Reader>
void expect_error(Reader reader, const std::string& text, const std::string& part) {
  try {
    read_text(reader, text);
    FAIL() << "no error for: " << text;
  } catch (const Error& e) {
    EXPECT_NE(std::string(e.what()).find(part), std::string::npos) << e.what();
  }
}

TEST(GroundTruth, Landmarks) {
  const auto plain = read_text(read_true_landmarks, "% head\n\n1 2 3 5 0 0 7\n-1 0 0 5 0 0 8\n");
  ASSERT_EQ(plain.size(), 2U);
  EXPECT_EQ(plain[0].id, 7);
  EXPECT_EQ(plain[0].position, Eigen::Vector3d(1, 2, 3));
  EXPECT_EQ(plain[0].class_name, "");
  EXPECT_EQ(read_text(read_true_landmarks, "1 2 3 5 0 0 7 tree\n")[0].class_name, "tree");
  EXPECT_EQ(read_text(read_true_landmarks, "% classes: tree car\n1 2 3 5 0 0 7 1\n")[0].class_name,
            "car");
  expect_error(read_true_landmarks, "1 2 3 5 0 0\n", ":1:12: 6 columns");
  expect_error(read_true_landmarks, "%\n1 2 x 5 0 0 7\n", ":2:5: 'x' is not a number");
  expect_error(read_true_landmarks, "1 2 nan 5 0 0 7\n", ":1:5: 'nan' is not a finite");
  expect_error(read_true_landmarks, "1 2 3 5 0 0 7.5\n", "'7.5' is not a whole number");
  expect_error(read_true_landmarks, "1 2 3 5 0 0 7\n1 2 4 5 0 0 7\n", ":2:13: landmark 7");
  expect_error(read_true_landmarks, "% classes: a\n1 2 3 5 0 0 7 1\n", ":2:15: class 1");
  expect_error(read_true_landmarks, "1 2 3 5 0 0 7 1\n", ":1:15: class 1, but no line");
  expect_error(read_true_landmarks, "% nothing\n", "holds no row");
  EXPECT_THROW(read_true_landmarks("no/such.txt"), Error);
}

TEST(GroundTruth, RobotPath) {
  const auto path = read_text(read_true_path, "% x y z yaw pitch roll\n1 2 3 0.1 0.2 0.3\n");
  ASSERT_EQ(path.size(), 1U);
  EXPECT_NEAR(path[0].yaw(), 0.1, 1e-12);
  EXPECT_NEAR(path[0].pitch(), 0.2, 1e-12);
  EXPECT_NEAR(path[0].roll(), 0.3, 1e-12);
  expect_error(read_true_path, "1 2 3 4 5 6 7\n", ": 7 columns");
  expect_error(
      read_true_path, "1 0 0 0 0 0 0 1\n",
      "8 columns; expected: x y z yaw pitch roll (a TUM trajectory is told by a name in .tum)");
}

TEST(GroundTruth, APathOfNumberedSteps) {
  const auto path = read_text(read_numbered_path, "0 0 0 0\n1 2 3 0.1\n");
  ASSERT_EQ(path.size(), 2U);
  EXPECT_EQ(path[1].x(), 2);
  EXPECT_EQ(path[1].z(), 0);
  EXPECT_NEAR(path[1].yaw(), 0.1, 1e-12);
  EXPECT_TRUE(read_text(is_numbered_path, "0 0 0 0\n"));
  EXPECT_FALSE(read_text(is_numbered_path, "0 0 0 0 0 0\n"));
  expect_error(read_numbered_path, "0 0 0 0\n2 0 0 0\n", ":2:1: step 1 is expected here");
  expect_error(read_numbered_path, "0 0 0\n", "3 columns; expected: step x y yaw");
}

TEST(GroundTruth, Tum) {
  const auto poses = read_text(read_tum, "# t x y z q\n1.5 1 2 3 0 0 0.6 0.8\n2 0 0 0 0 0 0 1\n");
  ASSERT_EQ(poses.size(), 2U);
  EXPECT_EQ(poses[0].time, 1.5);
  EXPECT_NEAR(poses[0].pose.yaw(), 2 * std::atan2(0.6, 0.8), 1e-12);
  EXPECT_EQ(poses[0].pose.z(), 3);
  expect_error(read_tum, "1 0 0 0 0 0 0 2\n", "norm 2.000");
  expect_error(read_tum, "2 0 0 0 0 0 0 1\n1 0 0 0 0 0 0 1\n", ":2:1: time 1");
  expect_error(read_tum, "1 0 0 0 0 0 1\n", ": 7 columns");
}

TEST(GroundTruth, PositionsAndBeacons) {
  const auto fixes = read_text(read_positions, "1.5 1 2 3\n2 0 0 0\n");
  ASSERT_EQ(fixes.size(), 2U);
  EXPECT_EQ(fixes[0].pose.y(), 2);
  expect_error(read_positions, "1 2 3\n", ":1:6: 3 columns");
  expect_error(read_positions, "2 0 0 0\n1 0 0 0\n", ":2:1: time 1");
  const auto beacons = read_text(read_true_landmarks, "4 1 2 3 0 0 0 0 0 0 0 0\n");
  EXPECT_EQ(beacons.at(0).id, 4);
  EXPECT_EQ(beacons[0].position, Eigen::Vector3d(1, 2, 3));
}

}  // namespace
}  // namespace hybrid
