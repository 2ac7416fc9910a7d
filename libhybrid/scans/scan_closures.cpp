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
/// Standard deviations that a window covers, and its least size [m], [rad]. Errors of a path have
/// heavy tails, since some matches are wrong: this is what holds 99.7 % of a Student t of 4 degrees
/// of freedom, by which the evidence for closures is judged, too.
constexpr double kCovered = 6.6;
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
    return (pose.translation() - closure.pose.motion.translation()).norm();
  };
  const auto nearest =
      std::min_element(map.poses.begin(), map.poses.end(),
                       [&](const SE2& a, const SE2& b) { return distance(a) < distance(b); });
  closure.from = map.anchor + static_cast<std::size_t>(nearest - map.poses.begin());
  closure.pose.motion = nearest->between(closure.pose.motion);
}

/// The first keyframe of the present local map within the last metres of a way.
std::size_t begin_of_stretch(const ScanTracker& tracker, double length) {
  const std::vector<ScanKeyframe>& keyframes = tracker.keyframes();
  const double begin = keyframes.back().travelled - length;
  std::size_t k = keyframes.size() - 1;
  while (k > tracker.local_maps().back().anchor && keyframes[k - 1].travelled >= begin) --k;
  return k;
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
  const LocalMap& map = tracker.local_maps().back();
  const SE2& last = map.poses.back();
  std::vector<SurfacePoint> points;
  const std::size_t begin = begin_of_stretch(tracker, length) - map.anchor;
  for (std::size_t i = map.count; i-- > begin;) {
    const std::vector<SurfacePoint> seen =
        transformed(last.between(map.poses[i]), tracker.keyframes()[map.anchor + i].points);
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

/// The last metres, and how they are known beside a match.
ScanClosureSearch::Stretch ScanClosureSearch::present_stretch(const ScanTracker& tracker,
                                                              const Relation& relation) const {
  const std::size_t newest = tracker.keyframes().size() - 1;
  const std::size_t begin = begin_of_stretch(tracker, options_.query_length);
  Stretch stretch;
  stretch.points = recent_points(tracker, options_.query_length);
  stretch.way = tracker.keyframes()[newest].travelled - tracker.keyframes()[begin].travelled;
  if (begin < newest) stretch.walk = relation(begin, newest).covariance;
  stretch.shared = std::max(1.0, stretch.way / options_.every);
  return stretch;
}

/// The places of a stretch walk at random relative to its end, and so does their mean by a third of
/// that. The same holds for the map around the keyframe to which a closure refers, or from the
/// anchor of stored scans to the place. Closures of successive searches share points and walk, so
/// that each tells a share of what the stretch does.
void ScanClosureSearch::Stretch::widen(double from_anchor, Eigen::Matrix3d& covariance) const {
  const double steps = 2.0 / 3.0 + (way > 0.0 ? from_anchor / way : 0.0);
  covariance = shared * (covariance + steps * walk);
}

/// Adds all poses at which the stretch under way matches a local map or stored scans; false where
/// these cannot be seen from where it may be.
bool ScanClosureSearch::look(const ScanTracker& tracker, const Candidate& candidate,
                             const TargetName& name, const Relation& relation,
                             const Stretch& stretch, std::vector<ScanClosure>& closures) {
  const std::size_t newest = tracker.keyframes().size() - 1;
  const std::size_t from = name.is_stored ? name.number : tracker.local_maps()[name.number].anchor;
  const SearchWindow window = window_of(relation(from, newest), options_);
  if (candidate.distance > options_.view + window.reach.maxCoeff()) return false;
  const std::vector<MatchMode> modes =
      match(stretch.points, target(tracker, name), window, options_.match);
  const std::size_t first = closures.size();
  for (const MatchMode& mode : modes) {
    closures.push_back({from, newest, mode.pose, mode.inliers, static_cast<int>(modes.size()),
                        first, name.is_stored});
    const double from_anchor = mode.pose.motion.translation().norm();
    if (!name.is_stored) refer_to_nearest(tracker.local_maps()[name.number], closures.back());
    stretch.widen(name.is_stored ? from_anchor : 0.0, closures.back().pose.covariance);
  }
  return true;
}

std::vector<ScanClosure> ScanClosureSearch::search(const ScanTracker& tracker, const Poses& poses,
                                                   const Relation& relation,
                                                   const Relation& stored) {
  std::vector<ScanClosure> closures;
  const double way = tracker.keyframes().back().travelled;
  if (way < next_ || options_.most_maps == 0) return closures;
  next_ = way + options_.every;
  const std::vector<Candidate> near = candidates(tracker, poses);
  const std::vector<Candidate> near_stored =
      stored_candidates(poses(tracker.keyframes().size() - 1));
  if (near.empty() && near_stored.empty()) return closures;
  const Stretch stretch = present_stretch(tracker, relation);
  std::vector<std::size_t> searched;
  for (const Candidate& candidate : near) {
    if (static_cast<int>(searched.size()) >= options_.most_maps) break;
    const bool overlaps = std::any_of(searched.begin(), searched.end(), [&](std::size_t m) {
      return m + 1 == candidate.map || candidate.map + 1 == m;
    });
    if (overlaps) continue;
    const TargetName name{false, candidate.map};
    if (look(tracker, candidate, name, relation, stretch, closures)) {
      searched.push_back(candidate.map);
    }
  }
  int left = options_.most_maps;
  for (const Candidate& candidate : near_stored) {
    if (left == 0) break;
    const TargetName name{true, candidate.map};
    left -= look(tracker, candidate, name, stored, stretch, closures) ? 1 : 0;
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
