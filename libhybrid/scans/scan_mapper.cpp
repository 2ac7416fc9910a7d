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

Key pose_key(std::size_t keyframe) {
  return {key_letter::kPose, keyframe};
}

ContinuousFactorPtr motion_factor(Key from, Key to, const UncertainMotion& measured) {
  return std::make_shared<BetweenSE2>(from, to, measured.motion,
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
  if (a == b) return {SE2(), Eigen::Matrix3d::Zero()};
  return relation_of(pose_key(a), pose_key(b), selection_.smoother());
}

void ScanMapper::adopt(std::vector<StoredScans> stored, const UncertainMotion& start) {
  search_.store(std::move(stored));
  start_ = start;
}

/// The anchors of stored scans become variables with their first closures.
void ScanMapper::insert_stored(const std::vector<ScanClosure>& found, Delta& delta) const {
  for (const ScanClosure& closure : found) {
    if (!closure.is_stored) continue;
    const Key key = place_key(closure.from);
    if (selection_.smoother().values().contains(key) || delta.values.contains(key)) continue;
    const StoredScans& scans = search_.stored()[closure.from];
    delta.values.insert(key, scans.T_map_anchor);
    delta.continuous.push_back(known_pose(key, scans.T_map_anchor, scans.covariance));
  }
}

/// The motion to a keyframe from the one before, by odometry and match together.
UncertainMotion ScanMapper::motion_to(const TrackedScan& tracked) const {
  const KeyframeMotion& odometry = tracked.odometry;
  if (!tracked.match) return odometry.measured;
  UncertainMotion match = tracked.match->measured;
  if (tracked.match->from != odometry.from) {
    match = relation(odometry.from, tracked.match->from) * match;
  }
  const Eigen::Matrix3d information =
      odometry.measured.covariance.inverse() + match.covariance.inverse();
  return {match.motion, information.inverse()};
}

/// Closures of a keyframe that is not in the graph yet, with the motion to it.
std::vector<ScanClosure> ScanMapper::search(const Delta& motion, const TrackedScan& tracked) {
  const std::size_t before = tracked.odometry.from;
  const UncertainMotion step = motion_to(tracked);
  const SE2 here = motion.values.at<SE2>(pose_key(tracked.keyframe));
  const auto pose_of = [&](std::size_t i) { return i == tracked.keyframe ? here : pose(i); };
  const auto uncertain = [&](const SE2& from, const UncertainMotion& to_before) {
    return UncertainMotion{from.between(here), (to_before * step).covariance};
  };
  return search_.search(
      tracker_, pose_of,
      [&](std::size_t a, std::size_t) { return uncertain(pose(a), relation(a, before)); },
      [&](std::size_t stored, std::size_t) {  // as if the errors of both were independent
        const StoredScans& scans = search_.stored()[stored];
        const UncertainMotion anchor{SE2(), scans.covariance};
        const UncertainMotion from_anchor{
            scans.T_map_anchor.between(pose(before)),
            selection_.smoother().joint_covariance({pose_key(before)})};
        return uncertain(scans.T_map_anchor, anchor * from_anchor);
      });
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
  const auto add = [&](const KeyframeMotion& motion) {
    delta.continuous.push_back(motion_factor(pose_key(motion.from), pose_key(k), motion.measured));
  };
  add(tracked.odometry);
  if (tracked.match) add(*tracked.match);
  const std::vector<ScanClosure> found = search(delta, tracked);
  insert_stored(found, delta);
  std::vector<ContinuousFactorPtr> factors;
  Alternatives modes;
  for (const ScanClosure& closure : found) {
    modes.add(closure.first_mode);
    const Key from = closure.is_stored ? place_key(closure.from) : pose_key(closure.from);
    factors.push_back(motion_factor(from, pose_key(closure.to), closure.mode.pose));
  }
  closures_.reserve(closures_.size() + found.size());
  selection_.update(delta, factors, modes);
  closures_.insert(closures_.end(), found.begin(), found.end());
}

TrackedScan ScanMapper::add(const LaserScan& scan, const std::optional<SE2>& odometry) {
  return add(scan_points(scan, options_.points), odometry);
}

TrackedScan ScanMapper::add(const std::vector<SurfacePoint>& points,
                            const std::optional<SE2>& odometry, KeyframeRule rule) {
  const Mark before = mark();
  try {
    const TrackedScan tracked = tracker_.track(points, odometry, rule);
    scans_.push_back({tracked.keyframe, tracked.T_keyframe_scan});
    if (tracked.is_keyframe) add_keyframe(tracked);
    return tracked;
  } catch (...) {
    roll_back(before);
    throw;
  }
}

void ScanMapper::roll_back(const Mark& mark) {
  tracker_.roll_back(mark.tracker);
  scans_.resize(mark.scans);
  search_.go_back_to(mark.next_search);
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
