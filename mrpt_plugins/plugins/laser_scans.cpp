// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, the hybrid mapping authors

#include "mrpt_plugins/plugins/laser_scans.h"

#include <cmath>
#include <memory>
#include <utility>

#include "libhybrid/factors/between.h"
#include "mrpt_plugins/bridge/pose_conversions.h"
#include "mrpt_plugins/mapping/register_plugin.h"

HYBRID_REGISTER_PLUGIN(LaserScans, hybrid)

namespace hybrid {
namespace {

/// What a planar match tells about height [m], roll and pitch [rad] in a map in space: that the
/// robot stands on the floor of a building.
constexpr double kHeight = 0.1;
constexpr double kTilt = 0.05;
/// Scans of the same time [s] and place are of several scanners. Time alone does not tell: clocks
/// that go back leave stamps that repeat.
constexpr double kSameTime = 1e-4;
constexpr double kSamePlace = 1e-9;

bool are_together(const LaserScan& a, const LaserScan& b) {
  return std::abs(a.time - b.time) < kSameTime &&
         (a.T_keyframe_robot.matrix() - b.T_keyframe_robot.matrix()).cwiseAbs().maxCoeff() <
             kSamePlace;
}

SE2 in_plane(const Eigen::Isometry3d& T) {
  const Eigen::Matrix3d R = T.linear();
  return {T.translation().x(), T.translation().y(), std::atan2(R(1, 0), R(0, 0))};
}

SE2 planar_pose(const Values& values, Key key, bool is_3d) {
  if (!is_3d) return values.at<SE2>(key);
  const SE3 pose = values.at<SE3>(key);
  Eigen::Isometry3d T = Eigen::Isometry3d::Identity();
  T.linear() = pose.rotation().matrix();
  T.translation() = pose.translation();
  return in_plane(T);
}

ContinuousFactorPtr factor_in_space(Key from, Key to, const UncertainMotion& measured) {
  const SE2& m = measured.motion;
  const SE3 motion(Eigen::Vector3d(m.x(), m.y(), 0.0),
                   SO3::exp(Eigen::Vector3d(0.0, 0.0, m.angle())));
  Eigen::MatrixXd covariance = Eigen::MatrixXd::Zero(6, 6);
  covariance.diagonal() << 0, 0, kHeight * kHeight, kTilt * kTilt, kTilt * kTilt, 0;
  const int places[] = {0, 1, 5};
  for (int i = 0; i < 3; ++i) {
    for (int j = 0; j < 3; ++j) covariance(places[i], places[j]) = measured.covariance(i, j);
  }
  return std::make_shared<Between<SE3>>(from, to, motion, Noise::covariance(covariance));
}

}  // namespace

void LaserScans::configure(IniSection section) {
  ScanTrackerOptions& tracker = options_.tracker;
  tracker.map_length =
      section.get("map_length", tracker.map_length,
                  "way that a local map spans, with which scans are matched [m]", kPositiveLength);
  ScanClosureOptions& closures = options_.closures;
  closures.most_maps = section.get("closures", true, "whether to search for places seen before")
                           ? closures.most_maps
                           : 0;
  closures.max_reach = section.get(
      "max_reach", closures.max_reach,
      "how far from where they should be such places are searched, at most [m]", kPositiveLength);
  options_.points.max_range = section.get("max_range", options_.points.max_range,
                                          "longer rays are not used [m]", kPositiveLength);
  mapper_.emplace(options_);
}

/// The motion from the last frame with scans by odometry; empty at the first.
std::optional<SE2> LaserScans::motion_to(const Frame& frame, const MapView& map) const {
  if (!last_pose_ || !map.values.contains(*last_pose_)) return std::nullopt;
  return planar_pose(map.values, *last_pose_, map.is_3d)
      .between(in_plane(to_isometry(frame.T_map_robot)));
}

/// Tracks all scans of a frame; those of the last time make the keyframe.
TrackedScan LaserScans::track(const Frame& frame, std::optional<SE2> from_before) {
  const std::vector<LaserScan>& scans = frame.scans;
  SE2 before;  // pose of the last scan in the frame of the keyframe
  if (from_before) before = from_before->inverse();
  for (std::size_t i = 0; i < scans.size();) {
    std::size_t end = i;
    std::vector<SurfacePoint> points;
    while (end < scans.size() && are_together(scans[end], scans[i])) {
      const std::vector<SurfacePoint> seen = scan_points(scans[end++], options_.points);
      points.insert(points.end(), seen.begin(), seen.end());
    }
    const SE2 place = in_plane(scans[i].T_keyframe_robot);
    const bool is_last = end == scans.size();
    // The keyframe sees the points of its last scan from where it is itself.
    if (is_last) points = transformed(place, points);
    std::optional<SE2> motion;
    const SE2 at = is_last ? SE2() : place;
    if (from_before || i > 0) motion = before.between(at);
    if (is_last) return mapper_->add(points, motion, KeyframeRule::kAlways);
    if (!keys_.empty()) {
      mapper_->add(points, motion, KeyframeRule::kNever);
      before = at;
      from_before = SE2();
    }
    i = end;
  }
  return {};
}

void LaserScans::add_factor(const KeyframeMotion& motion, std::size_t to, const MapView& map,
                            Contribution& out) const {
  const UncertainMotion& measured = motion.measured;
  const Key from = keys_[motion.from];
  if (map.is_3d) {
    out.delta.continuous.push_back(factor_in_space(from, keys_[to], measured));
  } else {
    out.delta.continuous.push_back(std::make_shared<BetweenSE2>(
        from, keys_[to], measured.motion, Noise::covariance(measured.covariance)));
  }
}

/// Closures accepted since the last time come in, those no longer accepted go out.
void LaserScans::follow_closures(const MapView& map, Contribution& out) {
  const std::vector<ScanClosure>& all = mapper_->closures();
  closures_.resize(all.size());
  for (std::size_t k = 0; k < all.size(); ++k) {
    const bool accepted = mapper_->status(k) == ClosureStatus::kAccepted;
    if (accepted == closures_[k].has_value()) continue;
    if (!accepted) {
      if (!map.keeps_all) continue;
      out.delta.remove.push_back(*closures_[k]);
      closures_[k].reset();
      continue;
    }
    const ScanClosure& closure = all[k];
    const bool newest = keys_[closure.to] == keys_.back();
    if (!map.holds(keys_[closure.from]) || !(newest || map.holds(keys_[closure.to]))) continue;
    add_factor({closure.from, closure.mode.pose, closure.mode.inliers}, closure.to, map, out);
    asked_.push_back(k);
    out.settle = true;
  }
}

Contribution LaserScans::observe(const Frame& frame, const MapView& map) {
  asked_.clear();
  Contribution out;
  if (frame.scans.empty()) return out;
  const TrackedScan tracked = track(frame, motion_to(frame, map));
  keys_.push_back(frame.pose);
  last_pose_ = frame.pose;
  if (tracked.match && map.holds(keys_[tracked.match->from])) {
    add_factor(*tracked.match, tracked.keyframe, map, out);
  }
  follow_closures(map, out);
  return out;
}

void LaserScans::applied(const Outcome& outcome) {
  const std::vector<Handle>& handles = outcome.handles.continuous;
  for (std::size_t i = 0; i < asked_.size(); ++i) {
    closures_[asked_[i]] = handles[handles.size() - asked_.size() + i];
  }
  asked_.clear();
}

Contribution LaserScans::conclude(const MapView& map) {
  asked_.clear();
  Contribution out;
  if (!concluded_) mapper_->finish();
  concluded_ = true;
  follow_closures(map, out);
  return out;
}

std::map<std::string, double> LaserScans::statistics() const {
  std::size_t accepted = 0;
  for (std::size_t k = 0; k < mapper_->closures().size(); ++k) {
    accepted += mapper_->status(k) == ClosureStatus::kAccepted ? 1 : 0;
  }
  const ScanTracker& tracker = mapper_->tracker();
  return {{"local_maps", double(tracker.local_maps().size())},
          {"scan_closures", double(mapper_->closures().size())},
          {"scan_closures_accepted", double(accepted)},
          {"scans_lost", double(tracker.lost())},
          {"odometry_translation_scale", tracker.odometry_noise().translation_scale()},
          {"odometry_rotation_scale", tracker.odometry_noise().rotation_scale()}};
}

}  // namespace hybrid
