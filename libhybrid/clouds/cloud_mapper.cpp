// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, the hybrid mapping authors

#include "libhybrid/clouds/cloud_mapper.h"

#include <algorithm>
#include <utility>

namespace hybrid {
namespace {

/// Sigma of a motion that nothing tells [reach], [rad].
constexpr double kUntoldTranslation = 1;
constexpr double kUntoldRotation = 1;

/// The motion to a cloud from the one before: what a match, and odometry where it is known, tell; a
/// motion that is hardly known where none of them does.
std::vector<UncertainMotion3> motions_to(const TrackedCloud& tracked,
                                         const std::optional<UncertainMotion3>& odometry,
                                         double reach) {
  std::vector<UncertainMotion3> out;
  if (tracked.match) out.push_back(tracked.match->measured);
  if (odometry) out.push_back(*odometry);
  if (!out.empty()) return out;
  out.push_back({tracked.T_before_cloud,
                 isotropic_covariance(kUntoldTranslation * std::max(reach, 1.0), kUntoldRotation)});
  return out;
}

}  // namespace

CloudMapper::CloudMapper(const CloudMapperOptions& options)
    : tracker_(options.tracker), search_(options.closures), graph_(options.selection) {}

void CloudMapper::adopt(std::vector<StoredCloud> stored, const UncertainMotion3& start) {
  std::vector<KnownPlace<SE3>> places;
  for (const StoredCloud& cloud : stored) places.push_back(cloud.T_map_anchor);
  graph_.adopt(std::move(places), start);
  search_.store(std::move(stored));
}

std::vector<CloudClosure> CloudMapper::search() {
  return search_.search(
      tracker_, [this](std::size_t i) { return pose(i); },
      [this](std::size_t a, std::size_t b) { return graph_.relation(a, b); },
      [this](std::size_t stored, std::size_t b) { return graph_.from_place(stored, b); });
}

TrackedCloud CloudMapper::add(const std::vector<Eigen::Vector3f>& points,
                              const Eigen::Vector3f& sensor,
                              const std::optional<UncertainMotion3>& odometry, bool is_at_once) {
  const TrackedCloud tracked = tracker_.track(points, sensor, odometry, is_at_once);
  const std::size_t k = tracked.cloud;
  if (k == 0) {
    graph_.begin();
    return tracked;
  }
  std::vector<ClosureGraph<SE3>::Motion> motions;
  for (const UncertainMotion3& motion : motions_to(tracked, odometry, tracker_.reach())) {
    motions.push_back({k - 1, motion});
  }
  graph_.add(graph_.step(k, pose(k - 1) * tracked.T_before_cloud, motions), {});
  const std::vector<CloudClosure> found = search();
  if (!found.empty()) graph_.add({}, found);
  return tracked;
}

void CloudMapper::finish() {
  if (tracker_.clouds() > 0) graph_.finish();
}

}  // namespace hybrid
