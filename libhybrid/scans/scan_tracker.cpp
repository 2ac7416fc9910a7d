// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, the hybrid mapping authors
#include "libhybrid/scans/scan_tracker.h"

#include <Eigen/LU>
#include <algorithm>
#include <cmath>

namespace hybrid {
namespace {

/// Errors of the prediction of the next scan: of odometry at scale 1 these are generous; a steady
/// motion knows nothing of acceleration [m], [rad].
constexpr double kPredictedTranslation = 0.02;
constexpr double kPredictedRotation = 0.01;
constexpr double kSteadyTranslation = 0.1;
constexpr double kSteadyRotation = 0.1;
/// The least motion between keyframes where much is new [m], [rad].
constexpr double kDenseDistance = 0.2;
constexpr double kDenseTurn = 0.1;
/// Surfaces are matched badly where a search may find a better pose.
constexpr double kDoubtful = 0.5;
/// Standard deviations of the prediction that a search covers, and its least and largest reach [m],
/// [rad].
constexpr double kSearched = 3.0;
constexpr double kLeastReach = 0.3;
constexpr double kMostReach = 1.5;
constexpr double kLeastTurn = 0.1;
constexpr double kMostTurn = 0.8;
/// A local map grows by errors of matches to its own keyframes, per metre from its anchor [m],
/// [rad].
constexpr double kGrowthTranslation = 0.002;
constexpr double kGrowthRotation = 0.0005;

}  // namespace

Eigen::Matrix3d ScanTracker::prior(const SE2& motion, bool by_odometry) const {
  const double distance = motion.translation().norm();
  const double turn = std::abs(motion.angle());
  Eigen::Vector3d least(kPredictedTranslation, kPredictedTranslation, kPredictedRotation);
  if (!by_odometry) least = {kSteadyTranslation, kSteadyTranslation, kSteadyRotation};
  Eigen::Matrix3d covariance = noise_.covariance(distance, turn);
  covariance.diagonal() += least.cwiseAbs2();
  return covariance;
}

ScanTracker::Aligned ScanTracker::aligned(const std::vector<SurfacePoint>& points,
                                          const SE2& predicted,
                                          const Eigen::Matrix3d& covariance) {
  AlignmentOptions options;
  options.prior = covariance.inverse();
  Aligned best{align(points, surfaces_, predicted, options), false};
  if (best.alignment.inliers < kDoubtful && !points.empty()) {
    if (!target_) target_ = make_match_target(map_points_);
    SearchWindow window;
    window.centre = predicted;
    const double reach = kSearched * std::sqrt(covariance.topLeftCorner<2, 2>().trace() / 2.0);
    window.reach.setConstant(std::clamp(reach, kLeastReach, kMostReach));
    window.turn = std::clamp(kSearched * std::sqrt(covariance(2, 2)), kLeastTurn, kMostTurn);
    MatchOptions match_options;
    match_options.min_inliers = options_.min_inliers;
    for (const MatchMode& mode : match(points, *target_, window, match_options)) {
      // A pose far from the prediction has to explain much more.
      if (mode.inliers < best.alignment.inliers + 0.1) continue;
      best.alignment = align(points, surfaces_, mode.pose.motion);
    }
  }
  best.good = best.alignment.inliers >= options_.min_inliers;
  return best;
}

bool ScanTracker::is_due(const SE2& from_last, double inliers, KeyframeRule rule) const {
  if (keyframes_.empty() || rule == KeyframeRule::kAlways) return true;
  if (rule == KeyframeRule::kNever) return false;
  const double distance = from_last.translation().norm();
  const double turn = std::abs(from_last.angle());
  if (distance > options_.keyframe_distance || turn > options_.keyframe_turn) return true;
  return inliers < options_.familiar && (distance > kDenseDistance || turn > kDenseTurn);
}

void ScanTracker::add_to_map(const std::vector<SurfacePoint>& points, const SE2& pose) {
  maps_.back().poses.push_back(pose);
  ++maps_.back().count;
  const std::vector<SurfacePoint> seen = transformed(pose, points);
  map_points_.insert(map_points_.end(), seen.begin(), seen.end());
}

/// Begins a local map with the second half of the present one.
void ScanTracker::begin_map() {
  const LocalMap before = maps_.back();
  const double middle = keyframes_.back().travelled - 0.5 * options_.map_length;
  std::size_t k = 1;
  while (k + 1 < before.count && (keyframes_[before.anchor + k].travelled < middle ||
                                  before.count - k > options_.map_keyframes / 2)) {
    ++k;
  }
  const SE2 anchor = before.poses[k];
  maps_.push_back({before.anchor + k, 0, {}});
  map_points_.clear();
  for (std::size_t i = k; i < before.count; ++i) {
    add_to_map(keyframes_[before.anchor + i].points, anchor.between(before.poses[i]));
  }
  pose_ = anchor.between(pose_);
}

void ScanTracker::add_keyframe(const std::vector<SurfacePoint>& points, const SE2& pose) {
  double travelled = 0.0;
  if (keyframes_.empty()) {
    maps_.push_back({});
  } else {
    const SE2 step = maps_.back().poses.back().between(pose);
    travelled = keyframes_.back().travelled + step.translation().norm();
  }
  keyframes_.push_back({points, travelled});
  add_to_map(points, pose);
  const LocalMap& map = maps_.back();
  if (map.count > 2 && (travelled - keyframes_[map.anchor].travelled > options_.map_length ||
                        map.count > options_.map_keyframes)) {
    begin_map();
  }
  surfaces_ = SurfaceMap(map_points_);
  target_.reset();
}

TrackedScan ScanTracker::track(const std::vector<SurfacePoint>& points,
                               const std::optional<SE2>& odometry, KeyframeRule rule) {
  TrackedScan result;
  if (keyframes_.empty()) {
    add_keyframe(points, SE2());
    result.is_keyframe = true;
    return result;
  }
  const SE2 motion = odometry.value_or(last_motion_);
  since_keyframe_ = since_keyframe_ * motion;
  way_ += motion.translation().norm();
  turn_ += std::abs(motion.angle());
  has_odometry_ = has_odometry_ && odometry.has_value();
  const SE2 predicted = pose_ * motion;
  const Aligned found = aligned(points, predicted, prior(motion, odometry.has_value()));
  SE2 pose = found.good ? found.alignment.pose : predicted;
  pose.normalize();  // products of many rotations drift from unit norm
  if (!found.good) ++lost_;
  last_motion_ = pose_.between(pose);
  pose_ = pose;
  const LocalMap& map = maps_.back();
  const SE2 last = map.poses.back();
  result.keyframe = keyframes_.size() - 1;
  result.T_keyframe_scan = last.between(pose);
  result.inliers = found.alignment.inliers;
  if (!is_due(result.T_keyframe_scan, found.alignment.inliers, rule)) return result;

  const UncertainMotion seen{result.T_keyframe_scan,
                             alignment_covariance(found.alignment)};
  if (found.good) {
    const double far = keyframes_.back().travelled - keyframes_[map.anchor].travelled;
    KeyframeMotion match{map.anchor, {pose, seen.covariance}, found.alignment.inliers};
    match.measured.covariance.diagonal() +=
        (far * Eigen::Vector3d(kGrowthTranslation, kGrowthTranslation, kGrowthRotation))
            .cwiseAbs2();
    result.match = match;
    if (has_odometry_) noise_.compare(since_keyframe_, way_, turn_, seen);
  }
  result.odometry = {result.keyframe, {since_keyframe_, noise_.covariance(way_, turn_)}};
  if (!has_odometry_) {
    result.odometry.measured.covariance.diagonal() +=
        Eigen::Vector3d(0.5 + way_, 0.5 + way_, 0.5 + turn_).cwiseAbs2();
  }
  add_keyframe(points, pose);
  result.keyframe = keyframes_.size() - 1;
  result.is_keyframe = true;
  result.T_keyframe_scan = SE2();
  since_keyframe_ = SE2();
  way_ = turn_ = 0.0;
  has_odometry_ = true;
  return result;
}

}  // namespace hybrid
