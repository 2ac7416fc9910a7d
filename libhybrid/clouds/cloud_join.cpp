// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, the hybrid mapping authors

#include "libhybrid/clouds/cloud_join.h"

#include <algorithm>
#include <cstddef>
#include <map>
#include <utility>

#include "libhybrid/clouds/cloud_place.h"
#include "libhybrid/geometry/isometry.h"
#include "libhybrid/scans/scan_join.h"

namespace hybrid {
namespace {

/// Standard deviations of the motion between two maps about a place that was found, of which else
/// nothing is known [spacings], [rad].
constexpr double kPlaceSpacings = 5;
constexpr double kPlaceAngle = 0.1;
/// Share of the points of a local cloud that lie on surfaces of another, which sees other sides of
/// things, at least.
constexpr double kLeastShared = 0.3;
/// Half of the window in which clouds are matched, in what a look for a place sees.
constexpr double kWindow = 1;

std::vector<StoredPlace<SE3>> places_of(const std::vector<StoredCloud>& stored) {
  std::vector<StoredPlace<SE3>> out;
  for (const StoredCloud& cloud : stored) {
    out.push_back({cloud.T_map_anchor, middle_of(cloud.points), cloud.points.empty()});
  }
  return out;
}

/// A place that was found: the motion between the maps, and where a stretch of the second is.
struct FoundPlace {
  SE3 T_first_second;
  SE3 stretch;  // in the second map
};

/// Looks for stretches of the second map in the first, until a place stands out.
std::optional<FoundPlace> find_place(const std::vector<StoredCloud>& second,
                                     CloudPlaceSearch& search) {
  const std::size_t step = std::max<std::size_t>(1, second.size() / JoinGraph<SE3>::kMostStretches);
  for (std::size_t k = 0; k < second.size(); k += step) {
    const StoredCloud& cloud = second[k];
    const SE3 T_anchor_middle(middle_of(cloud.points), SO3());
    const SE3 stretch = cloud.T_map_anchor.motion * T_anchor_middle;
    const auto found = search.look(transformed(T_anchor_middle.inverse(), cloud.points), stretch);
    if (found) return FoundPlace{found->motion, stretch};
  }
  return std::nullopt;
}

/// Matches of the clouds of both maps, those near a place of the second first.
JoinGraph<SE3> matched(const std::vector<StoredCloud>& first,
                       const std::vector<StoredCloud>& second, const UncertainMotion3& motion,
                       const Eigen::Vector3d& where, double view) {
  CloudMatchOptions options;
  options.max_reach = kWindow * view;
  options.min_inliers = kLeastShared;
  std::map<std::size_t, CloudTarget> targets;  // as they are needed
  const auto match_places = [&](std::size_t i, std::size_t k, const UncertainMotion3& predicted) {
    auto target = targets.find(i);
    if (target == targets.end()) {
      target = targets
                   .emplace(i, make_cloud_target(first[i].points, first[i].spacing,
                                                 first[i].T_map_anchor.motion))
                   .first;
    }
    std::vector<UncertainMotion3> modes;
    for (const CloudAlignment& mode : match(second[k].points, target->second, predicted, options)) {
      modes.push_back({mode.pose, alignment_covariance(mode)});
    }
    return modes;
  };
  return {places_of(first), places_of(second),
          motion,           where,
          match_places,     {2 * view, CloudClosureOptions().most_maps}};
}

/// The motion between two maps, as known at a place that was found, not at the origin of the second
/// map.
UncertainMotion3 motion_at(const FoundPlace& place, double spacing) {
  const Matrix6 Ad = place.stretch.adjoint();
  const Matrix6 at_place = isotropic_covariance(kPlaceSpacings * spacing, kPlaceAngle);
  return {place.T_first_second, Ad * at_place * Ad.transpose()};
}

}  // namespace

std::vector<StoredCloud> stored_clouds(const MapRecord& map) {
  std::vector<StoredCloud> out;
  for (const MapLocalCloud& local : map.local_clouds) {
    StoredCloud cloud{local.T_map_anchor, {}, local.spacing};
    cloud.points.reserve(local.points.size());
    for (const MapCloudPoint& p : local.points) {
      cloud.points.push_back({p.position, p.normal.normalized()});  // zero stays zero
    }
    out.push_back(std::move(cloud));
  }
  return out;
}

std::vector<CloudPoint> surfaces_of(const std::vector<StoredCloud>& stored) {
  if (stored.empty()) return {};
  CloudSurfaces all(widest_spacing(stored));
  for (const StoredCloud& cloud : stored) {
    all.add(transformed(cloud.T_map_anchor.motion, cloud.points));
  }
  return all.points();
}

std::vector<PlaceMatch<SE3>> common_places(const std::vector<StoredCloud>& first,
                                           const std::vector<StoredCloud>& second,
                                           const UncertainMotion3& T_first_second) {
  if (first.empty() || second.empty()) return {};
  const Eigen::Vector3d where =
      nearest_anchor(places_of(first), places_of(second), T_first_second.motion);
  return matched(first, second, T_first_second, where, view_of(widest_spacing(first))).accepted();
}

std::optional<JoinedMaps> join_maps_by_clouds(const MapRecord& first, const MapRecord& second,
                                              double odds, std::string& why) {
  refuse_to_join(first, second);
  if (!first.is_3d || first.local_clouds.empty() || second.local_clouds.empty()) {
    why = "there are no clouds in both to find a common place by";
    return std::nullopt;
  }
  const std::vector<StoredCloud> in_first = stored_clouds(first), in_second = stored_clouds(second);
  CloudPlaceOptions options;
  options.odds = odds;
  CloudPlaceSearch search(in_first, options);
  const auto place = find_place(in_second, search);
  if (!place) {
    why = search.doubt();
    return std::nullopt;
  }
  const JoinGraph<SE3> graph =
      matched(in_first, in_second, motion_at(*place, in_first.front().spacing),
              place->stretch.translation(), search.view());
  const std::size_t accepted = graph.accepted().size();
  if (accepted < JoinGraph<SE3>::kLeastMatches) {
    why = "its clouds fit at a place, but of " + std::to_string(graph.matches()) +
          " matches there only " + std::to_string(accepted) + " agree with each other";
    return std::nullopt;
  }
  const UncertainMotion3 motion = graph.motion();
  JoinedMaps out = join_maps_at(first, second, to_isometry(motion.motion), motion.covariance);
  out.scan_matches = accepted;
  out.log_odds = search.log_odds();
  const std::vector<KnownPlace<SE3>> anchors = graph.anchors();
  for (std::size_t m = 0; m < anchors.size(); ++m) {
    out.map.local_clouds[m].T_map_anchor = anchors[m];
  }
  return out;
}

std::optional<JoinedMaps> join_maps_by_places(const MapRecord& first, const MapRecord& second,
                                              double odds, std::string& why) {
  why.clear();
  if (first.is_3d) {
    if (first.local_clouds.empty() || second.local_clouds.empty()) return std::nullopt;
    return join_maps_by_clouds(first, second, odds, why);
  }
  if (first.local_maps.empty() || second.local_maps.empty()) return std::nullopt;
  return join_maps_by_scans(first, second, odds, why);
}

}  // namespace hybrid
