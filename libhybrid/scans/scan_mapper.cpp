// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, the hybrid mapping authors
#include "libhybrid/scans/scan_mapper.h"

#include <memory>
#include <utility>

#include "libhybrid/core/key_letters.h"
#include "libhybrid/factors/between.h"
#include "libhybrid/factors/prior.h"

namespace hybrid {
namespace {

/// The anchors of stored scans are poses whose numbers begin here, above those of keyframes.
constexpr std::size_t kFirstStored = std::size_t{1} << 30;

Key pose_key(std::size_t keyframe) {
  return {key_letter::kPose, keyframe};
}

Key stored_key(std::size_t stored) {
  return pose_key(kFirstStored + stored);
}

ContinuousFactorPtr motion_factor(std::size_t from, std::size_t to,
                                  const UncertainMotion& measured) {
  return std::make_shared<BetweenSE2>(pose_key(from), pose_key(to), measured.motion,
                                      Noise::covariance(measured.covariance));
}

ContinuousFactorPtr known_pose(Key key, const SE2& pose, const Eigen::Matrix3d& covariance) {
  return std::make_shared<Prior<SE2>>(key, pose, Noise::covariance(covariance));
}

}  // namespace

ScanMapper::ScanMapper(const ScanMapperOptions& options)
    : options_(options),
      tracker_(options.tracker),
      search_(options.closures),
      selection_(options.selection) {}

SE2 ScanMapper::pose(std::size_t keyframe) const {
  return selection_.smoother().values().at<SE2>(pose_key(keyframe));
}

UncertainMotion ScanMapper::relation(std::size_t a, std::size_t b) const {
  return relation_of(pose_key(a), pose_key(b), selection_.smoother());
}

void ScanMapper::adopt(std::vector<StoredScans> stored, const UncertainMotion& start) {
  search_.store(std::move(stored));
  start_ = start;
}

/// The pose of a keyframe in the frame of stored scans, as if both errors were independent.
UncertainMotion ScanMapper::stored_relation(std::size_t stored, std::size_t keyframe) const {
  const StoredScans& scans = search_.stored()[stored];
  const SE2 motion = scans.T_map_anchor.between(pose(keyframe));
  const Eigen::Matrix3d Ad = motion.inverse().adjoint();
  Eigen::Matrix3d covariance = selection_.smoother().joint_covariance(
      {pose_key(keyframe)}, Eigen::MatrixXd(Eigen::Matrix3d::Identity()));
  covariance += Ad * scans.covariance * Ad.transpose();
  return {motion, covariance};
}

/// The anchors of stored scans become variables with their first closures.
void ScanMapper::insert_stored(const std::vector<ScanClosure>& found) {
  Delta delta;
  for (const ScanClosure& closure : found) {
    if (!closure.is_stored) continue;
    const Key key = stored_key(closure.from);
    if (selection_.smoother().values().contains(key) || delta.values.contains(key)) continue;
    const StoredScans& scans = search_.stored()[closure.from];
    delta.values.insert(key, scans.T_map_anchor);
    delta.continuous.push_back(known_pose(key, scans.T_map_anchor, scans.covariance));
  }
  if (!delta.continuous.empty()) selection_.update(delta);
}

void ScanMapper::add_keyframe(const TrackedScan& tracked) {
  const std::size_t k = tracked.keyframe;
  Delta delta;
  if (k == 0) {
    delta.values.insert(pose_key(0), start_.motion);
    delta.continuous.push_back(known_pose(pose_key(0), start_.motion, start_.covariance));
    selection_.update(delta);
    return;
  }
  const KeyframeMotion& start = tracked.match ? *tracked.match : tracked.odometry;
  delta.values.insert(pose_key(k), pose(start.from) * start.measured.motion);
  delta.continuous.push_back(motion_factor(tracked.odometry.from, k, tracked.odometry.measured));
  if (tracked.match) {
    delta.continuous.push_back(motion_factor(tracked.match->from, k, tracked.match->measured));
  }
  selection_.update(delta);
  const std::vector<ScanClosure> found = search_.search(
      tracker_, [this](std::size_t i) { return pose(i); },
      [this](std::size_t i, std::size_t j) { return relation(i, j); },
      [this](std::size_t i, std::size_t j) { return stored_relation(i, j); });
  if (found.empty()) return;
  insert_stored(found);
  std::vector<ContinuousFactorPtr> factors;
  Alternatives modes;
  for (const ScanClosure& closure : found) {
    modes.add(closure.first_mode);
    const std::size_t from = closure.is_stored ? kFirstStored + closure.from : closure.from;
    factors.push_back(motion_factor(from, closure.to, closure.mode.pose));
  }
  closures_.insert(closures_.end(), found.begin(), found.end());
  selection_.update({}, factors, modes);
}

TrackedScan ScanMapper::add(const LaserScan& scan, const std::optional<SE2>& odometry) {
  return add(scan_points(scan, options_.points), odometry);
}

TrackedScan ScanMapper::add(const std::vector<SurfacePoint>& points,
                            const std::optional<SE2>& odometry, KeyframeRule rule) {
  const TrackedScan tracked = tracker_.track(points, odometry, rule);
  scans_.push_back({tracked.keyframe, tracked.T_keyframe_scan});
  if (tracked.is_keyframe) add_keyframe(tracked);
  return tracked;
}

void ScanMapper::finish() {
  if (!scans_.empty()) selection_.finish();
}

std::vector<SE2> ScanMapper::path() const {
  std::vector<SE2> path;
  path.reserve(scans_.size());
  for (const Placed& scan : scans_) path.push_back(pose(scan.keyframe) * scan.T_keyframe_scan);
  return path;
}

}  // namespace hybrid
