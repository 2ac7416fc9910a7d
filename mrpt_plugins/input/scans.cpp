// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, the hybrid mapping authors

#include "mrpt_plugins/input/scans.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <utility>

#include "mrpt_plugins/bridge/pose_conversions.h"
#include "mrpt_plugins/bridge/poses.h"

namespace hybrid {
namespace {

using mrpt::obs::CObservation2DRangeScan;

/// A field of view may exceed a whole turn by what single precision does to it [rad].
constexpr double kAngleTolerance = 1e-3;
/// A laser is level, either way up, if its axis is within this of the vertical [rad]: from half a
/// metre above the floor, rays of one that tilts more end on it within 2 m.
constexpr double kMostTilt = 15 * M_PI / 180;

/// Why a scan is unusable, or null.
const char* fault(const CObservation2DRangeScan& scan, double field_of_view,
                  const ScanOptions& options) {
  const auto& pose = scan.sensorPose;
  if (scan.getScanSize() == 0) return "scan dropped: no rays";
  const bool is_open = field_of_view > 0 && field_of_view <= 2 * M_PI + kAngleTolerance;
  if (scan.getScanSize() > 1 && !is_open) {
    return "scan dropped: field of view absurd";
  }
  if (scan.deltaPitch != 0) return "scan dropped: the sensor tilts while it sweeps";
  if (!std::isfinite(pose.norm()) || !pose.getRotationMatrix().asEigen().allFinite()) {
    return "scan dropped: sensor pose not finite";
  }
  if (pose.norm() > options.max_range || !is_rotation(pose)) {
    return "scan dropped: sensor pose absurd";
  }
  const bool is_level = std::abs(pose.getRotationMatrix()(2, 2)) >= std::cos(kMostTilt);
  return is_level ? nullptr : "scan dropped: the laser is not level";
}

/// Ranges with NaN for rays that see nothing.
std::vector<float> checked_ranges(const CObservation2DRangeScan& scan, double max_range) {
  std::vector<float> ranges(scan.getScanSize(), std::numeric_limits<float>::quiet_NaN());
  for (std::size_t i = 0; i < ranges.size(); ++i) {
    const float range = scan.getScanRange(i);
    if (scan.getScanRangeValidity(i) && range > 0 && range < max_range) ranges[i] = range;
  }
  return ranges;
}

}  // namespace

std::optional<LaserScan> scan_in(const mrpt::obs::CObservation& observation,
                                 const ScanOptions& options, DropReport& report) {
  const auto* scan = dynamic_cast<const CObservation2DRangeScan*>(&observation);
  if (scan == nullptr) return std::nullopt;
  const double field_of_view =
      options.field_of_view > 0 ? options.field_of_view : static_cast<double>(scan->aperture);
  if (const char* reason = fault(*scan, field_of_view, options)) {
    ++report[reason];
    return std::nullopt;
  }
  LaserScan out;
  const bool is_limited = std::isfinite(scan->maxRange) && scan->maxRange > 0;
  out.max_range =
      is_limited ? std::min<double>(scan->maxRange, options.max_range) : options.max_range;
  out.ranges = checked_ranges(*scan, out.max_range);
  const double sign = scan->rightToLeft ? 1 : -1;
  const std::size_t steps = out.ranges.size() - 1;
  out.first_angle = steps > 0 ? -sign * field_of_view / 2 : 0;
  out.angle_step = steps > 0 ? sign * field_of_view / static_cast<double>(steps) : 0;
  out.T_robot_sensor = to_isometry(scan->sensorPose);
  return out;
}

CObservation2DRangeScan::Ptr to_mrpt(const LaserScan& scan) {
  auto out = CObservation2DRangeScan::Create();
  out->timestamp = mrpt::Clock::fromDouble(scan.time);
  out->sensorLabel = "LASER";
  const std::size_t rays = scan.ranges.size();
  const double opening = rays > 1 ? scan.angle_step * static_cast<double>(rays - 1) : 0;
  out->aperture = static_cast<float>(std::abs(opening));
  out->rightToLeft = opening >= 0;
  out->maxRange = static_cast<float>(scan.max_range);
  out->sensorPose = to_mrpt(scan.T_robot_sensor) +
                    mrpt::poses::CPose3D(0, 0, 0, scan.first_angle + opening / 2, 0, 0);
  out->resizeScan(rays);
  for (std::size_t i = 0; i < rays; ++i) {
    const bool is_seen = std::isfinite(scan.ranges[i]) && scan.ranges[i] > 0;
    out->setScanRange(i, is_seen ? scan.ranges[i] : 0);
    out->setScanRangeValidity(i, is_seen);
  }
  return out;
}

bool is_halved_scan(const mrpt::obs::CObservation& observation) {
  constexpr std::size_t kRays = 180;
  constexpr double kDegree = M_PI / 180;
  const auto* scan = dynamic_cast<const CObservation2DRangeScan*>(&observation);
  return scan != nullptr && scan->getScanSize() == kRays &&
         std::abs(scan->aperture - M_PI_2) < kDegree;
}

void ScanCollector::move(const std::optional<OdometryIncrement>& odometry, DropReport& report) {
  ++step_;
  if (odometry) {
    T_keyframe_robot_ = T_keyframe_robot_ * to_isometry(odometry->mean);
    return;
  }
  if (!scans_.empty()) {
    report["scan dropped: no odometry from there to a keyframe"] += scans_.size();
  }
  scans_.clear();
  T_keyframe_robot_.setIdentity();
}

void ScanCollector::add(LaserScan scan, DropReport& report) {
  if (stride_ > 1) thin_out(report);  // the step before, which could have been a keyframe
  scan.T_keyframe_robot = T_keyframe_robot_;
  scans_.push_back({step_, std::move(scan)});
  if (scans_.size() <= kMost) return;
  stride_ *= 2;
  thin_out(report);
}

/// Whether a scan is of a step that is not kept. The present one is: it may be a keyframe.
bool ScanCollector::is_left_out(const Collected& collected) const {
  return collected.step != step_ && collected.step % stride_ != 0;
}

void ScanCollector::thin_out(DropReport& report) {
  const auto kept =
      std::remove_if(scans_.begin(), scans_.end(),
                     [this](const Collected& collected) { return is_left_out(collected); });
  const auto left_out = static_cast<std::size_t>(scans_.end() - kept);
  scans_.erase(kept, scans_.end());
  if (left_out > 0) report["scan thinned out: one of too many between two keyframes"] += left_out;
}

std::vector<LaserScan> ScanCollector::release() {
  const Eigen::Isometry3d T_now_before = T_keyframe_robot_.inverse();
  std::vector<LaserScan> out;
  for (Collected& collected : scans_) {
    Eigen::Isometry3d& T = collected.scan.T_keyframe_robot;
    const bool is_here = T.matrix() == T_keyframe_robot_.matrix();
    T = is_here ? Eigen::Isometry3d::Identity() : T_now_before * T;  // of the keyframe exactly
    out.push_back(std::move(collected.scan));
  }
  scans_.clear();
  step_ = 0;
  stride_ = 1;
  T_keyframe_robot_.setIdentity();
  return out;
}

}  // namespace hybrid
