// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, the hybrid mapping authors

#include "libhybrid/scans/scan_join.h"

#include <algorithm>
#include <cmath>
#include <cstdio>

#include "libhybrid/geometry/isometry.h"

namespace hybrid {
namespace {

/// Points of stored scans are so far apart [m].
constexpr double kStoredSpacing = 0.1;
/// Standard deviations of the motion between two maps about a place that was found, of which else
/// nothing is known [m], [rad].
constexpr double kPlaceSigma = 0.5;
constexpr double kPlaceTurn = 0.1;
Eigen::Vector2d mean_of(const std::vector<SurfacePoint>& points) {
  Eigen::Vector2d sum = Eigen::Vector2d::Zero();
  for (const SurfacePoint& point : points) sum += point.position;
  return sum / double(std::max<std::size_t>(points.size(), 1));
}

std::string number(const char* format, double value) {
  char text[32];
  std::snprintf(text, sizeof text, format, value);
  return text;
}

std::string text_of(const ScanPlace& place) {
  const SE2 at = place.T_map_drive.motion * place.stretch;
  return "(" + number("%.1f", at.x()) + " " + number("%.1f", at.y()) + ") with " +
         number("%.0f", 100 * place.on / std::max(1e-9, place.on + place.off)) +
         " % of their surfaces";
}

/// What speaks against the best of places that do not stand out.
std::string doubt_of(const ScanPlaceSearch& search, const ScanPlaceOptions& options) {
  const std::vector<ScanPlace>& places = search.places();
  if (places.empty()) return "no stretch of its laser scans fits those of the other map";
  const ScanPlace& best = places.front();
  if (static_cast<int>(best.seen_from.size()) < options.votes) {
    return "the place that fits its laser scans best, " + text_of(best) + ", has " +
           std::to_string(best.seen_from.size()) + " of the " + std::to_string(options.votes) +
           " stretches that must agree";
  }
  if (places.size() > 1 && best.fit - places[1].fit <= std::log(options.odds)) {
    return "its laser scans fit at " + text_of(best) + ", and as well at " + text_of(places[1]);
  }
  return "its laser scans may fit by chance at " + text_of(best) + ", log odds " +
         number("%.1f", search.log_odds()) + " of " + number("%.1f", std::log(options.odds)) +
         " that are needed";
}

std::vector<StoredPlace<SE2>> places_of(const std::vector<StoredScans>& stored) {
  std::vector<StoredPlace<SE2>> out;
  for (const StoredScans& scans : stored) {
    out.push_back({scans.T_map_anchor, mean_of(scans.points), scans.points.empty()});
  }
  return out;
}

/// Matches of the scans of both maps, those near a place of the second first.
JoinGraph<SE2> matched(const std::vector<StoredScans>& first,
                       const std::vector<StoredScans>& second, const UncertainMotion& motion,
                       const Eigen::Vector2d& where) {
  const ScanClosureOptions options;
  std::vector<std::optional<MatchTarget>> targets(first.size());  // as they are needed
  const auto match_places = [&](std::size_t i, std::size_t k, const UncertainMotion& predicted) {
    if (!targets[i]) targets[i] = make_match_target(first[i].points);
    const SearchWindow window = window_of(predicted, options);
    std::vector<UncertainMotion> modes;
    for (const MatchMode& mode : match(second[k].points, *targets[i], window, options.match)) {
      modes.push_back(mode.pose);
    }
    return modes;
  };
  return {places_of(first), places_of(second),
          motion,           where,
          match_places,     {options.view + options.max_reach, options.most_maps}};
}

/// The motion between two maps, as known at a place that was found, not at the origin of the second
/// map.
UncertainMotion motion_at(const ScanPlace& place) {
  const Eigen::Matrix3d Ad = place.stretch.adjoint();
  const Eigen::Matrix3d at_place =
      Eigen::Vector3d(kPlaceSigma, kPlaceSigma, kPlaceTurn).cwiseAbs2().asDiagonal();
  return {place.T_map_drive.motion, Ad * at_place * Ad.transpose()};
}

}  // namespace

std::vector<StoredScans> stored_scans(const MapRecord& map) {
  std::vector<StoredScans> out;
  for (const MapLocalMap& local : map.local_maps) {
    StoredScans scans;
    scans.T_map_anchor = {SE2(local.pose.x(), local.pose.y(), local.pose.z()), local.covariance};
    scans.T_map_anchor.parent = local.parent;
    for (const MapSurface& surface : local.surfaces) {
      SurfacePoint point;
      point.position = surface.position;
      if (surface.direction) {
        point.normal << std::cos(*surface.direction), std::sin(*surface.direction);
      }
      point.length = kStoredSpacing;
      scans.points.push_back(point);
    }
    out.push_back(std::move(scans));
  }
  return out;
}

ScanJoin join_scans(const std::vector<StoredScans>& first, const std::vector<StoredScans>& second,
                    const ScanPlaceOptions& options) {
  ScanJoin out;
  ScanPlaceSearch search(first, options);
  const ScanPlace* found = nullptr;
  // Of local maps that overlap, every second one: what a surface says counts once.
  const std::size_t step = std::max<std::size_t>(2, second.size() / JoinGraph<SE2>::kMostStretches);
  for (std::size_t k = 0; k < second.size() && found == nullptr; k += step) {
    const SE2 T_anchor_middle(mean_of(second[k].points), SO2());
    found = search.look(transformed(T_anchor_middle.inverse(), second[k].points),
                        second[k].T_map_anchor.motion * T_anchor_middle);
  }
  if (found == nullptr) {
    out.why = doubt_of(search, options);
    return out;
  }
  const JoinGraph<SE2> graph =
      matched(first, second, motion_at(*found), found->stretch.translation());
  out.matches = graph.matches();
  out.accepted = graph.accepted().size();
  out.log_odds = search.log_odds();
  if (out.accepted < JoinGraph<SE2>::kLeastMatches) {
    out.why = "its laser scans fit at " + text_of(*found) + ", but of " +
              std::to_string(out.matches) + " matches there only " + std::to_string(out.accepted) +
              " agree with each other";
    return out;
  }
  out.T_first_second = graph.motion();
  out.anchors = graph.anchors();
  return out;
}

std::vector<PlaceMatch<SE2>> common_places(const std::vector<StoredScans>& first,
                                           const std::vector<StoredScans>& second,
                                           const UncertainMotion& T_first_second) {
  if (first.empty() || second.empty()) return {};
  const Eigen::Vector2d where =
      nearest_anchor(places_of(first), places_of(second), T_first_second.motion);
  return matched(first, second, T_first_second, where).accepted();
}

std::optional<JoinedMaps> join_maps_by_scans(const MapRecord& first, const MapRecord& second,
                                             double odds, std::string& why) {
  refuse_to_join(first, second);
  if (first.is_3d || first.local_maps.empty() || second.local_maps.empty()) {
    why = "there are no laser scans in the plane in both to find a common place by";
    return std::nullopt;
  }
  ScanPlaceOptions options;
  options.odds = odds;
  const ScanJoin join = join_scans(stored_scans(first), stored_scans(second), options);
  why = join.why;
  if (!join.is_found()) return std::nullopt;
  JoinedMaps out = join_maps_at(first, second, to_isometry(join.T_first_second.motion),
                                join.T_first_second.covariance);
  out.scan_matches = join.accepted;
  out.log_odds = join.log_odds;
  for (std::size_t m = 0; m < join.anchors.size(); ++m) {
    const SE2& pose = join.anchors[m].motion;
    out.map.local_maps[m].pose << pose.x(), pose.y(), pose.angle();
    out.map.local_maps[m].covariance = join.anchors[m].covariance;
    out.map.local_maps[m].parent = join.anchors[m].parent;
  }
  return out;
}

}  // namespace hybrid
