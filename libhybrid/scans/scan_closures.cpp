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

/// Points of the last `length` metres in the frame of the last keyframe.
std::vector<SurfacePoint> query_points(const ScanTracker& tracker, double length) {
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
  std::vector<SurfacePoint> joined;
  const SurfaceMap merged(points, kQuerySpacing);
  for (const SurfaceMap::Surfel& surfel : merged.surfels()) {
    joined.push_back({surfel.position, surfel.normal, surfel.length / surfel.count});
  }
  return joined;
}

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

}  // namespace

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

const MatchTarget& ScanClosureSearch::target(const ScanTracker& tracker, std::size_t map) {
  Stored& stored = targets_[map];
  stored.used = ++searches_;
  if (stored.target == nullptr) {
    const LocalMap& local = tracker.local_maps()[map];
    std::vector<SurfacePoint> points;
    for (std::size_t i = 0; i < local.count; ++i) {
      const std::vector<SurfacePoint> seen =
          transformed(local.poses[i], tracker.keyframes()[local.anchor + i].points);
      points.insert(points.end(), seen.begin(), seen.end());
    }
    stored.target = std::make_shared<const MatchTarget>(make_match_target(points));
    if (targets_.size() > kMostTargets) {
      const auto oldest = std::min_element(
          targets_.begin(), targets_.end(),
          [](const auto& a, const auto& b) { return a.second.used < b.second.used; });
      targets_.erase(oldest);
    }
  }
  return *targets_.at(map).target;
}

std::vector<ScanClosure> ScanClosureSearch::search(const ScanTracker& tracker, const Poses& poses,
                                                   const Relation& relation) {
  std::vector<ScanClosure> closures;
  const std::size_t newest = tracker.keyframes().size() - 1;
  const double way = tracker.keyframes().back().travelled;
  if (way < next_) return closures;
  next_ = way + options_.every;
  std::vector<SurfacePoint> query;
  std::vector<std::size_t> searched;
  for (const Candidate& candidate : candidates(tracker, poses)) {
    if (static_cast<int>(searched.size()) >= options_.most_maps) break;
    const LocalMap& map = tracker.local_maps()[candidate.map];
    const bool overlaps = std::any_of(searched.begin(), searched.end(), [&](std::size_t m) {
      return m + 1 == candidate.map || candidate.map + 1 == m;
    });
    if (overlaps) continue;
    const UncertainMotion predicted = relation(map.anchor, newest);
    const SearchWindow window = window_of(predicted, options_);
    if (candidate.distance > options_.view + window.reach.maxCoeff()) continue;
    if (query.empty()) query = query_points(tracker, options_.query_length);
    searched.push_back(candidate.map);
    const std::vector<MatchMode> modes =
        match(query, target(tracker, candidate.map), window, options_.match);
    for (const MatchMode& mode : modes) {
      closures.push_back({map.anchor, newest, mode, static_cast<int>(modes.size())});
    }
  }
  return closures;
}

}  // namespace hybrid
