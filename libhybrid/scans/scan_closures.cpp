// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, the hybrid mapping authors
#include "libhybrid/scans/scan_closures.h"

#include <algorithm>
#include <cmath>
#include <limits>

namespace hybrid {
namespace {

/// Targets kept in memory; others are made again when needed.
constexpr std::size_t kMostTargets = 40;
/// Standard deviations that a window covers, and its least size [m], [rad].
constexpr double kCovered = 3.0;
constexpr double kLeastWindow = 0.4;
constexpr double kLeastWindowTurn = 0.08;
/// Points of a query closer than this are one [m].
constexpr double kQuerySpacing = 0.1;

/// Points closer than a spacing joined.
std::vector<SurfacePoint> joined(const std::vector<SurfacePoint>& points) {
  std::vector<SurfacePoint> out;
  const SurfaceMap merged(points, kQuerySpacing);
  for (const SurfaceMap::Surfel& surfel : merged.surfels()) {
    out.push_back({surfel.position, surfel.normal, surfel.length / surfel.count});
  }
  return out;
}

/// Makes a closure with a local map, from its anchor, one with its keyframe nearest to where the
/// mode is: what lies between that and the anchor is not known as well as the match is.
void refer_to_nearest(const LocalMap& map, ScanClosure& closure) {
  const auto distance = [&](const SE2& pose) {
    return (pose.translation() - closure.mode.pose.motion.translation()).norm();
  };
  const auto nearest =
      std::min_element(map.poses.begin(), map.poses.end(),
                       [&](const SE2& a, const SE2& b) { return distance(a) < distance(b); });
  closure.from = map.anchor + static_cast<std::size_t>(nearest - map.poses.begin());
  closure.mode.pose.motion = nearest->between(closure.mode.pose.motion);
}

}  // namespace

SearchWindow window_of(const UncertainMotion& predicted, const ScanClosureOptions& options) {
  const Eigen::Matrix2d R = predicted.motion.rotation().matrix();
  const Eigen::Matrix2d C = R * predicted.covariance.topLeftCorner<2, 2>() * R.transpose();
  SearchWindow window;
  window.centre = predicted.motion;
  window.reach.x() = std::clamp(kCovered * std::sqrt(C(0, 0)), kLeastWindow, options.max_reach);
  window.reach.y() = std::clamp(kCovered * std::sqrt(C(1, 1)), kLeastWindow, options.max_reach);
  window.turn = std::clamp(kCovered * std::sqrt(predicted.covariance(2, 2)), kLeastWindowTurn,
                           options.max_turn);
  return window;
}

std::vector<SurfacePoint> recent_points(const ScanTracker& tracker, double length) {
  const std::vector<ScanKeyframe>& keyframes = tracker.keyframes();
  const LocalMap& map = tracker.local_maps().back();
  const double begin = keyframes.back().travelled - length;
  const SE2& last = map.poses.back();
  std::vector<SurfacePoint> points;
  for (std::size_t i = map.count; i-- > 0;) {
    const ScanKeyframe& keyframe = keyframes[map.anchor + i];
    if (i + 1 < map.count && keyframe.travelled < begin) break;
    const std::vector<SurfacePoint> seen = transformed(last.between(map.poses[i]), keyframe.points);
    points.insert(points.end(), seen.begin(), seen.end());
  }
  return joined(points);
}

/// Finished local maps that were left behind, nearest first, of those that overlap only the
/// nearest.
std::vector<ScanClosureSearch::Candidate> ScanClosureSearch::candidates(const ScanTracker& tracker,
                                                                        const Poses& poses) const {
  const std::vector<LocalMap>& maps = tracker.local_maps();
  const Eigen::Vector2d here = poses(tracker.keyframes().size() - 1).translation();
  std::vector<Candidate> near;
  const std::size_t present = maps.back().anchor;
  for (std::size_t m = 0; m + 1 < maps.size(); ++m) {
    const LocalMap& map = maps[m];
    if (map.anchor + map.count > present) continue;
    const SE2 anchor = poses(map.anchor);
    double nearest = std::numeric_limits<double>::infinity();
    for (const SE2& pose : map.poses) {
      nearest = std::min(nearest, (anchor * pose.translation() - here).norm());
    }
    if (nearest < options_.view + options_.max_reach) near.push_back({m, nearest});
  }
  std::stable_sort(near.begin(), near.end(),
                   [](const Candidate& a, const Candidate& b) { return a.distance < b.distance; });
  return near;
}

/// Stored scans that may be seen from a place, nearest first.
std::vector<ScanClosureSearch::Candidate> ScanClosureSearch::stored_candidates(
    const SE2& here) const {
  std::vector<Candidate> near;
  for (std::size_t m = 0; m < stored_.size(); ++m) {
    const Eigen::Vector2d at = stored_[m].T_map_anchor.inverse() * here.translation();
    double nearest = std::numeric_limits<double>::infinity();
    for (const SurfacePoint& point : stored_[m].points) {
      nearest = std::min(nearest, (point.position - at).norm());
    }
    if (nearest < options_.view + options_.max_reach) near.push_back({m, nearest});
  }
  std::stable_sort(near.begin(), near.end(),
                   [](const Candidate& a, const Candidate& b) { return a.distance < b.distance; });
  return near;
}

/// Made when first needed, and kept as long as it is among those used last.
const MatchTarget& ScanClosureSearch::target(const ScanTracker& tracker, const TargetName& name) {
  KeptTarget& kept = targets_[name];
  kept.used = ++searches_;
  if (kept.target == nullptr) {
    kept.target = std::make_shared<const MatchTarget>(
        make_match_target(name.is_stored ? stored_[name.number].points
                                         : tracker.points(tracker.local_maps()[name.number])));
    if (targets_.size() > kMostTargets) {
      const auto oldest = std::min_element(
          targets_.begin(), targets_.end(),
          [](const auto& a, const auto& b) { return a.second.used < b.second.used; });
      targets_.erase(oldest);
    }
  }
  return *targets_.at(name).target;
}

std::vector<ScanClosure> ScanClosureSearch::search(const ScanTracker& tracker, const Poses& poses,
                                                   const Relation& relation,
                                                   const Relation& stored) {
  std::vector<ScanClosure> closures;
  const std::size_t newest = tracker.keyframes().size() - 1;
  const double way = tracker.keyframes().back().travelled;
  if (way < next_) return closures;
  next_ = way + options_.every;
  std::vector<SurfacePoint> query;
  const auto look = [&](const ScanClosure& found, const SearchWindow& window,
                        const TargetName& name) {
    if (query.empty()) query = recent_points(tracker, options_.query_length);
    const std::vector<MatchMode> modes =
        match(query, target(tracker, name), window, options_.match);
    const std::size_t first = closures.size();
    for (const MatchMode& mode : modes) {
      closures.push_back(found);
      closures.back().first_mode = first;
      closures.back().mode = mode;
      closures.back().modes = static_cast<int>(modes.size());
      if (!name.is_stored) refer_to_nearest(tracker.local_maps()[name.number], closures.back());
    }
  };
  std::vector<std::size_t> searched;
  for (const Candidate& candidate : candidates(tracker, poses)) {
    if (static_cast<int>(searched.size()) >= options_.most_maps) break;
    const LocalMap& map = tracker.local_maps()[candidate.map];
    const bool overlaps = std::any_of(searched.begin(), searched.end(), [&](std::size_t m) {
      return m + 1 == candidate.map || candidate.map + 1 == m;
    });
    if (overlaps) continue;
    const SearchWindow window = window_of(relation(map.anchor, newest), options_);
    if (candidate.distance > options_.view + window.reach.maxCoeff()) continue;
    searched.push_back(candidate.map);
    look({map.anchor, newest, {}, 1, 0, false}, window, {false, candidate.map});
  }
  if (stored_.empty() || options_.most_maps == 0) return closures;
  int left = options_.most_maps;
  for (const Candidate& candidate : stored_candidates(poses(newest))) {
    const SearchWindow window = window_of(stored(candidate.map, newest), options_);
    if (candidate.distance > options_.view + window.reach.maxCoeff()) continue;
    look({candidate.map, newest, {}, 1, 0, true}, window, {true, candidate.map});
    if (--left == 0) break;
  }
  return closures;
}

std::vector<LocalScans> local_scans(const ScanTracker& tracker) {
  std::vector<LocalScans> out;
  for (const LocalMap& local : tracker.local_maps()) {
    out.push_back({local.anchor, joined(tracker.points(local))});
  }
  return out;
}

}  // namespace hybrid
