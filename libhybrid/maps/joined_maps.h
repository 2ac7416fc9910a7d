// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, the hybrid mapping authors

#pragma once

#include <cstdint>
#include <vector>

#include "libhybrid/maps/map_record.h"

namespace HYBRID_API hybrid {

/// A landmark that two maps have at different places, by its id. One of these is left out.
struct Contradiction {
  std::int64_t id = 0;
  double distance = 0;      ///< between the places, once the maps are joined [m]
  bool first_kept = false;  ///< the place in the first map, where it was seen at least as often
};

/// Two maps as one.
struct JoinedMaps {
  MapRecord map;  ///< in the frame of the first
  Eigen::Isometry3d T_first_second = Eigen::Isometry3d::Identity();
  Eigen::MatrixXd covariance;  ///< of that, in the tangent of a right perturbation
  /// How much larger all variances would have to be for the common landmarks to fit; 1 where they
  /// do. Nothing is multiplied by it: maps that are too sure of themselves are all so.
  double variance_factor = 1;
  bool was_known = false;        ///< where the second map is in the first
  std::size_t common = 0;        ///< landmarks that both have
  std::size_t scan_matches = 0;  ///< of laser scans or clouds of both that were accepted
  double log_odds = 0;           ///< for the common landmarks against none
  std::vector<Contradiction> contradictions;
};

}  // namespace hybrid
