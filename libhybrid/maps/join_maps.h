// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, the hybrid mapping authors

#pragma once

#include <cstdint>
#include <optional>
#include <vector>

#include "libhybrid/maps/joined_maps.h"

namespace HYBRID_API hybrid {

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
