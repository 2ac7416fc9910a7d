// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, the hybrid mapping authors

#include "libhybrid/detections/sensor_coverage.h"

#include <algorithm>
#include <cmath>

#include "libhybrid/geometry/polar.h"
#include "libhybrid/geometry/so2.h"

namespace hybrid {
namespace {

/// Detections that the number of landmarks expected in view counts as much as before any.
constexpr double kPriorDetections = 10;
/// Landmarks in view that the expected detection probability counts as much as before any.
constexpr double kPriorInView = 10;
constexpr double kWellInView = 0.9;  // share of range and field of view
/// Detections that are all to one side of a sensor that looks ahead are a chance of 2^-30 where
/// they are of as many things, and rare where they are of a few.
constexpr std::size_t kSureOfSide = 30;

}  // namespace

void SensorCoverage::learn(const DetectionFrame& frame) {
  min_range = frame.min_range;
  for (const Detection& d : frame.detections) max_range = std::max(max_range, d.range);
  if (frame.max_range > 0) max_range = frame.max_range;
  constexpr double kLeastView = 0.2;  // rad
  double yaw = kLeastView, pitch = frame.is_3d ? kLeastView : 0;
  for (const Detection& d : frame.detections) {
    learn_direction(d.yaw);
    yaw = std::max(yaw, 2 * std::abs(d.yaw));
    pitch = std::max(pitch, 2 * std::abs(d.pitch));
  }
  symmetric_ = std::max(symmetric_, yaw);
  const bool aside = frame.fov_yaw <= 0 && looks_aside();
  fov_yaw = frame.fov_yaw > 0 ? frame.fov_yaw
            : aside           ? std::max(kLeastView, leftmost_ - rightmost_)
                              : symmetric_;
  center_yaw = aside ? wrap_angle(0.5 * (leftmost_ + rightmost_)) : 0;
  if (frame.is_3d) fov_pitch = frame.fov_pitch > 0 ? frame.fov_pitch : std::max(fov_pitch, pitch);
}

void SensorCoverage::learn_direction(double yaw) {
  if (directions_++ == 0) rightmost_ = leftmost_ = wrap_angle(yaw);
  const double middle = 0.5 * (rightmost_ + leftmost_), away = wrap_angle(yaw - middle);
  const double left = middle + away;
  if (leftmost_ - rightmost_ >= 2 * M_PI) return;
  rightmost_ = std::min(rightmost_, left);
  leftmost_ = std::max(leftmost_, left);
}

bool SensorCoverage::looks_aside() const {
  const double middle = 0.5 * (rightmost_ + leftmost_);
  return directions_ >= kSureOfSide &&
         std::abs(wrap_angle(middle)) > 0.5 * (leftmost_ - rightmost_);
}

double SensorCoverage::expected_in_view(double before) const {
  return (kPriorDetections * before + around) / (kPriorDetections + detections);
}

double density_of_landmarks(const std::map<std::string, SensorCoverage>& sensors, double before) {
  double most = 0;
  for (const auto& [label, sensor] : sensors) {
    if (sensor.max_range > 0) most = std::max(most, sensor.density(before));
  }
  return most;
}

double SensorCoverage::detection_probability(double before) const {
  const double p = (kPriorInView * before + seen) / (kPriorInView + in_view);
  return std::clamp(p, 0.1, 0.9);
}

double SensorCoverage::measurement_volume() const {
  return (max_range - min_range) * fov_yaw * (fov_pitch > 0 ? fov_pitch : 1.0);
}

double SensorCoverage::space_in_view() const {
  if (fov_pitch == 0) return 0.5 * fov_yaw * max_range * max_range;
  return fov_yaw * 2 * std::sin(0.5 * fov_pitch) * std::pow(max_range, 3) / 3;
}

bool SensorCoverage::well_in_view(const Eigen::Isometry3d& T_map_sensor,
                                  const Eigen::Vector3d& point) const {
  const Eigen::Vector3d polar = to_polar(
      Eigen::Vector3d(T_map_sensor.linear().transpose() * (point - T_map_sensor.translation())));
  const double range = polar[0], yaw = polar[1], pitch = polar[2];
  return range > min_range && range < kWellInView * max_range &&
         std::abs(wrap_angle(yaw - center_yaw)) < 0.5 * kWellInView * fov_yaw &&
         (fov_pitch == 0 || std::abs(pitch) < 0.5 * kWellInView * fov_pitch);
}

}  // namespace hybrid
