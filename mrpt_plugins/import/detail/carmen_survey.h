// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, the hybrid mapping authors

#pragma once

#include <mrpt/math/wrap2pi.h>
#include <mrpt/poses/CPose2D.h>

#include <cmath>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <string_view>

#include "libhybrid/geometry/eigen.h"
#include "libhybrid/io/parse_number.h"
#include "mrpt_plugins/import/detail/carmen_lines.h"
#include "mrpt_plugins/import/detail/carmen_odometry.h"

namespace hybrid {

inline constexpr double kRoundedLength = 0.02;  // m, of poses that are written in centimetres
inline constexpr double kRoundedAngle = 0.01;   // rad
inline constexpr double kMostOffset = 5;        // m, of a laser from the middle of its robot
inline constexpr double kMostLag = 1;  // s, by which a line is written later than what it tells

/// The word behind as many others as word `at` says; nothing where it is no number.
inline std::optional<std::size_t> behind_list(const TextRow& row, std::size_t at) {
  std::uint64_t count = 0;
  if (row.size() <= at || !parse_number(row[at], count) || count > row.size()) return std::nullopt;
  return at + 1 + static_cast<std::size_t>(count);
}

/// The word behind ranges and remissions of ROBOTLASER1 and RAWLASER1 lines.
inline std::optional<std::size_t> behind_lists(const TextRow& row) {
  const auto remissions = behind_list(row, 8);
  return remissions ? behind_list(row, *remissions) : std::nullopt;
}

inline std::optional<double> number_at(const TextRow& row, std::size_t at) {
  double value = 0;
  if (row.size() <= at || !parse_number(row[at], value) || !std::isfinite(value)) {
    return std::nullopt;
  }
  return value;
}

/// Where the lines of a laser have it on the robot, by their pose of the laser and that of the
/// robot behind it.
class CarmenMount {
 public:
  /// Takes the poses from word `at` of a line on; what cannot be read tells nothing.
  void take(const TextRow& row, std::size_t at);

  /// Whether the laser keeps its place on the robot, as far as the lines tell. It does not in logs
  /// whose poses of the laser were corrected.
  bool is_fixed() const { return is_fixed_; }
  /// That place; nothing where it is not fixed.
  std::optional<mrpt::poses::CPose2D> place() const;

 private:
  std::size_t lines_ = 0;
  bool is_fixed_ = true;
  mrpt::poses::CPose2D first_;
  Eigen::Vector3d sum_ = Eigen::Vector3d::Zero();  // of differences to the first
};

/// What all lines of a log tell together, which is asked before they are converted.
class CarmenSurvey {
 public:
  explicit CarmenSurvey(CarmenLines& lines);

  bool has_odometry = false;  // in lines of its own
  CarmenMount front_laser;    // of FLASER lines
  CarmenMount robot_laser;    // of ROBOTLASER1 lines

  /// Whether times of ODOM and RAWLASER1 lines are of one clock and do not go back.
  bool has_one_clock() const {
    constexpr std::size_t kUsual = 10;  // one line in so many may be late
    return is_ordered_ && scans_ > 0 && kUsual * strangers_ <= scans_;
  }

 private:
  void take_time_of_odometry(const TextRow& row);
  void take_time_of_scan(const TextRow& row);

  bool is_ordered_ = true, goes_back_ = false;
  std::optional<double> odometry_, scan_;  // times of the last lines
  std::size_t scans_ = 0, strangers_ = 0;  // those far from the ODOM lines around them
};

inline void CarmenMount::take(const TextRow& row, std::size_t at) {
  double p[6];
  for (std::size_t i = 0; i < 6; ++i) {
    const auto number = number_at(row, at + i);
    if (!number) return;
    p[i] = *number;
  }
  const mrpt::poses::CPose2D laser =
      mrpt::poses::CPose2D(p[0], p[1], p[2]) - mrpt::poses::CPose2D(p[3], p[4], p[5]);
  if (lines_++ == 0) first_ = laser;
  const Eigen::Vector3d off(laser.x() - first_.x(), laser.y() - first_.y(),
                            mrpt::math::wrapToPi(laser.phi() - first_.phi()));
  sum_ += off;
  is_fixed_ =
      is_fixed_ && off.head<2>().norm() <= kRoundedLength && std::abs(off.z()) <= kRoundedAngle;
}

inline std::optional<mrpt::poses::CPose2D> CarmenMount::place() const {
  if (lines_ < 2 || !is_fixed_ || first_.norm() > kMostOffset) return std::nullopt;
  const Eigen::Vector3d mean = sum_ / static_cast<double>(lines_);
  return mrpt::poses::CPose2D(first_.x() + mean.x(), first_.y() + mean.y(),
                              first_.phi() + mean.z());
}

inline CarmenSurvey::CarmenSurvey(CarmenLines& lines) {
  TextRow row;
  while (lines.next(row)) {
    is_ordered_ = is_ordered_ && !goes_back_;  // the last line may be cut off
    const std::string_view word = row[0];
    if (word == "ODOM") {
      has_odometry = true;
      take_time_of_odometry(row);
    } else if (word == "RAWLASER1") {
      take_time_of_scan(row);
    } else if (word == "FLASER") {
      if (const auto at = behind_list(row, 1)) front_laser.take(row, *at);
    } else if (word == "ROBOTLASER1") {
      if (const auto at = behind_lists(row)) robot_laser.take(row, *at);
    }
  }
  lines.rewind();
}

inline void CarmenSurvey::take_time_of_odometry(const TextRow& row) {
  const auto time = number_at(row, CarmenOdometry::kTime);
  goes_back_ = !time || (odometry_ && *time < *odometry_);
  if (scan_ && time && *scan_ > *time + kMostLag) ++strangers_;
  scan_.reset();
  odometry_ = time;
}

inline void CarmenSurvey::take_time_of_scan(const TextRow& row) {
  const auto at = behind_lists(row);
  const auto time = at ? number_at(row, *at) : std::nullopt;
  goes_back_ = !time;
  ++scans_;
  if (time && odometry_ && *time < *odometry_ - kMostLag) {
    ++strangers_;
  } else {
    scan_ = time;
  }
}

}  // namespace hybrid
