// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, the hybrid mapping authors
#include "libhybrid/scans/scan_mapper.h"

#include <utility>

namespace hybrid {

ScanMapper::ScanMapper(const ScanMapperOptions& options)
    : options_(options),
      tracker_(options.tracker),
      search_(options.closures),
      graph_(options.selection) {}

void ScanMapper::adopt(std::vector<StoredScans> stored, const UncertainMotion& start) {
  std::vector<KnownPlace<SE2>> places;
  for (const StoredScans& scans : stored) places.push_back(scans.T_map_anchor);
  graph_.adopt(std::move(places), start);
  search_.store(std::move(stored));
}

/// The motion to a keyframe from the one before, by odometry and match together.
UncertainMotion ScanMapper::motion_to(const TrackedScan& tracked) const {
  const KeyframeMotion& odometry = tracked.odometry;
  if (!tracked.match) return odometry.measured;
  UncertainMotion match = tracked.match->measured;
  if (tracked.match->from != odometry.from) {
    match = graph_.relation(odometry.from, tracked.match->from) * match;
  }
  const Eigen::Matrix3d information =
      odometry.measured.covariance.inverse() + match.covariance.inverse();
  return {match.motion, information.inverse()};
}

/// Closures of a keyframe at `here`, which is not in the graph yet, with the motion to it.
std::vector<ScanClosure> ScanMapper::search(const SE2& here, const TrackedScan& tracked) {
  const std::size_t before = tracked.odometry.from;
  const UncertainMotion step = motion_to(tracked);
  const auto pose_of = [&](std::size_t i) { return i == tracked.keyframe ? here : pose(i); };
  const auto uncertain = [&](const SE2& from, const UncertainMotion& to_before) {
    return UncertainMotion{from.between(here), (to_before * step).covariance};
  };
  return search_.search(
      tracker_, pose_of,
      [&](std::size_t a, std::size_t) { return uncertain(pose(a), graph_.relation(a, before)); },
      [&](std::size_t stored, std::size_t) {
        return uncertain(graph_.places()[stored].motion, graph_.from_place(stored, before));
      });
}

void ScanMapper::add_keyframe(const TrackedScan& tracked) {
  if (tracked.keyframe == 0) {
    graph_.begin();
    return;
  }
  const KeyframeMotion& start = tracked.match ? *tracked.match : tracked.odometry;
  const SE2 here = pose(start.from) * start.measured.motion;
  std::vector<ClosureGraph<SE2>::Motion> motions{
      {tracked.odometry.from, tracked.odometry.measured}};
  if (tracked.match) motions.push_back({tracked.match->from, tracked.match->measured});
  const std::vector<ScanClosure> found = search(here, tracked);
  graph_.add(graph_.step(tracked.keyframe, here, motions), found);
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
  if (!scans_.empty()) graph_.finish();
}

std::vector<SE2> ScanMapper::path() const {
  std::vector<SE2> path;
  path.reserve(scans_.size());
  for (const Placed& scan : scans_) path.push_back(pose(scan.keyframe) * scan.T_keyframe_scan);
  return path;
}

}  // namespace hybrid
