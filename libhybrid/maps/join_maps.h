// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, the hybrid mapping authors

#pragma once

#include <cstdint>
#include <optional>
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

/// Finds where the second map is in the first by the landmarks that both have, makes these one,
/// and estimates all landmarks together, given what each map knows of its own. Landmarks of the
/// second that the first lacks get new ids, unless ids are those of logs. Where the maps have a
/// landmark of one id at different places (an id that was misread, a thing that was moved), the
/// place where it was seen less often is left out, and what else the maps have in common is not
/// concerned. Nothing where no common place stands out with these `odds`. Throws Error where the
/// maps are not of one kind, or both have a session of one log.
std::optional<JoinedMaps> join_maps(const MapRecord& first, const MapRecord& second, double odds);

/// Throws Error where two maps are not of one kind, or both have a session of one log.
void refuse_to_join(const MapRecord& first, const MapRecord& second);

/// Joins maps of which it is known where the second is in the first, in the tangent of a right
/// perturbation: landmarks that lie together are one, and there may be none. Throws Error as
/// join_maps().
JoinedMaps join_maps_at(const MapRecord& first, const MapRecord& second,
                        const Eigen::Isometry3d& T_first_second, const Eigen::MatrixXd& covariance);

/// The map without some landmarks, by their ids.
MapRecord without_landmarks(const MapRecord& map, const std::vector<std::int64_t>& ids);

}  // namespace hybrid
