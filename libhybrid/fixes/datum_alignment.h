// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, the hybrid mapping authors

#pragma once

#include <Eigen/Geometry>
#include <optional>
#include <vector>

#include "libhybrid/geometry/eigen.h"

namespace HYBRID_API hybrid {

/// A point of the robot in the map and where a fix says that it is [m].
struct DatumPair {
  Eigen::Vector3d in_map, in_datum;
  double sigma = 1;  ///< of each horizontal axis of the fix [m]
};

/// T_datum_map, a turn about the vertical and a shift, on which most pairs agree, within three
/// sigmas and what odometry drifts by. Nothing where no more than half do, or where the path is too
/// short to tell the direction to `most_sigma_turn` [rad], with the sigmas that the pairs show
/// where these are less than what is stated. Costs the number of pairs; the same pairs give the
/// same.
std::optional<Eigen::Isometry3d> align_to_datum(const std::vector<DatumPair>& pairs,
                                                double most_sigma_turn);

}  // namespace hybrid
