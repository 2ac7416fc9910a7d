// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, the hybrid mapping authors

#include "apps/hybrid-objects/quaternion_order.h"

#include <algorithm>
#include <utility>
#include <vector>

#include "libhybrid/core/quantile.h"

namespace hybrid {
namespace {

/// Median distance of the sightings of an object to their median in the odometry frame [m].
double spread(const std::vector<SE3>& odometry, const ObjectTrack& track) {
  std::vector<Eigen::Vector3d> seen;
  for (std::size_t i = 0; i < odometry.size(); ++i) {
    if (track.sightings[i]) seen.push_back(odometry[i] * track.sightings[i]->translation());
  }
  if (seen.empty()) return 0.0;
  Eigen::Vector3d middle;
  std::vector<double> values(seen.size());
  for (int axis = 0; axis < 3; ++axis) {
    std::transform(seen.begin(), seen.end(), values.begin(),
                   [axis](const Eigen::Vector3d& p) { return p[axis]; });
    middle[axis] = median(values);
  }
  std::transform(seen.begin(), seen.end(), values.begin(),
                 [&middle](const Eigen::Vector3d& p) { return (p - middle).norm(); });
  return median(std::move(values));
}

}  // namespace

bool seems_real_part_first(const ObjectSequence& sequence) {
  constexpr double kMuchBetter = 0.5;  // of the spread
  std::vector<SE3> turned;
  for (const SE3& pose : sequence.odometry) {
    const Eigen::Quaterniond q = pose.rotation().quaternion();
    turned.emplace_back(pose.translation(), Eigen::Quaterniond(q.x(), q.y(), q.z(), q.w()));
  }
  double as_read = 0, real_part_first = 0;
  for (const ObjectTrack& track : sequence.objects) {
    as_read += spread(sequence.odometry, track);
    real_part_first += spread(turned, track);
  }
  return real_part_first < kMuchBetter * as_read;
}

}  // namespace hybrid
