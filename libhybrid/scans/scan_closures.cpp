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
  for (std::size_t i = map.poses.size(); i-- > begin;) {
    const std::vector<SurfacePoint> seen =
        transformed(last.between(map.poses[i]), tracker.keyframes()[map.anchor + i].points);
    points.insert(points.end(), seen.begin(), seen.end());
  }
  return joined(points);
}

ScanClosureSearch::ScanClosureSearch(const ScanClosureOptions& options)
    : options_(options), targets_(kMostTargets) {}

/// Stored scans that may be seen from a place.
ScanClosureSearch::Near ScanClosureSearch::stored_near(const Eigen::Vector2d& here) const {
  Near near;
  for (std::size_t m = 0; m < stored_.size(); ++m) {
    const Eigen::Vector2d at = stored_[m].T_map_anchor.motion.inverse() * here;
    double nearest = std::numeric_limits<double>::infinity();
    for (const SurfacePoint& point : stored_[m].points) {
      nearest = std::min(nearest, (point.position - at).norm());
    }
    if (nearest < options_.view + options_.max_reach) near.emplace_back(nearest, m);
  }
  std::stable_sort(near.begin(), near.end());
  return near;
}

const MatchTarget& ScanClosureSearch::target(const ScanTracker& tracker, const PlaceName& name) {
  return targets_.at(name, [&] {
    return make_match_target(name.is_known ? stored_[name.number].points
                                           : tracker.points(tracker.local_maps()[name.number]));
  });
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

/// Adds all poses at which the stretch under way matches a local map or stored scans; false where
/// these cannot be seen from where it may be.
bool ScanClosureSearch::look(const ScanTracker& tracker, const PlaceName& name, double distance,
                             const Relation& relation, const Stretch& stretch,
                             std::vector<ScanClosure>& closures) {
  const std::size_t newest = tracker.keyframes().size() - 1;
  const std::size_t from = name.is_known ? name.number : tracker.local_maps()[name.number].anchor;
  const SearchWindow window = window_of(relation(from, newest), options_);
  if (distance > options_.view + window.reach.maxCoeff()) return false;
  const std::vector<MatchMode> modes =
      match(stretch.points, target(tracker, name), window, options_.match);
  const std::size_t first = closures.size();
  for (const MatchMode& mode : modes) {
    const double from_anchor = name.is_known ? mode.pose.motion.translation().norm() : 0.0;
    closures.push_back({from,
                        newest,
                        {mode.pose.motion, stretch.widened(mode.pose.covariance, from_anchor)},
                        mode.inliers,
                        static_cast<int>(modes.size()),
                        first,
                        name.is_known});
    if (!name.is_known) refer_to_nearest(tracker.local_maps()[name.number], closures.back());
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
  const Eigen::Vector2d here = poses(tracker.keyframes().size() - 1).translation();
  const Near near =
      maps_near(tracker.local_maps(), poses, here, options_.view + options_.max_reach);
  const Near near_stored = stored_near(here);
  if (near.empty() && near_stored.empty()) return closures;
  const Stretch stretch = present_stretch(tracker, relation);
  std::vector<std::size_t> searched;
  for (const auto& [distance, m] : near) {
    if (static_cast<int>(searched.size()) >= options_.most_maps) break;
    if (overlaps(searched, m)) continue;
    if (look(tracker, {false, m}, distance, relation, stretch, closures)) searched.push_back(m);
  }
  int left = options_.most_maps;
  for (const auto& [distance, m] : near_stored) {
    if (left == 0) break;
    left -= look(tracker, {true, m}, distance, stored, stretch, closures) ? 1 : 0;
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
