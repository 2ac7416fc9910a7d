// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, the hybrid mapping authors

#pragma once

#include <Eigen/Core>
#include <string>
#include <vector>

namespace hybrid {

/// A distance to an anchor of known position [m].
struct AnchorRange {
  int line = 0;  ///< in the file
  double time = 0, range = 0, variance = 0;
  Eigen::Vector2d anchor{0, 0};
  int anchor_id = 0;
};

/// Wheel speeds of a differential drive from a time on, and its speed to the left [m/s].
struct WheelSpeeds {
  double time = 0, left = 0, right = 0, side = 0;
  double half_base = 0;  ///< half the distance between the wheels [m]
  double variance_left = 0, variance_right = 0, variance_side = 0;
};

/// Ranges to anchors and odometry of a robot, each in order of time.
struct RangeLog {
  std::vector<AnchorRange> ranges;
  std::vector<WheelSpeeds> odometry;
};

/// Whether a file is a range log, by the first word of its first row.
bool is_range_log(const std::string& path);

/// Reads rows "range2 time range variance x y anchor ..." and "odom2diff time v_left v_right v_side
/// half_base var_left var_right var_side". The description of the data set calls the first wheel
/// the right one and the last length the whole base; with that, odometry contradicts the ranges.
/// Throws Error that names file and line.
RangeLog read_range_log(const std::string& path);

/// Time and position of rows "point2 time x y ...".
struct TruePoint {
  double time = 0;
  Eigen::Vector2d position{0, 0};
};
std::vector<TruePoint> read_true_points(const std::string& path);

}  // namespace hybrid
