// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, the hybrid mapping authors

#pragma once

#include <Eigen/Core>
#include <vector>

#include "libhybrid/geometry/eigen.h"
#include "libhybrid/geometry/se2.h"
#include "libhybrid/scans/likelihood_field.h"

namespace HYBRID_API hybrid {

/// Where to search: all poses whose translation differs from that of the centre by at most `reach`
/// along each axis of the map [m], and whose angle by at most `turn` [rad].
struct SearchWindow {
  SE2 centre;
  Eigen::Vector2d reach = Eigen::Vector2d::Zero();
  double turn = 0.0;
};

struct SearchOptions {
  double min_score = 0.3;  ///< poses of a lower mean likelihood are none
  double ratio = 0.85;     ///< of the scores of a mode and of the best one, at least
  int max_modes = 4;
  int budget = 60000;  ///< squares of poses scored, at most
  /// Poses closer than this belong to one mode [m], [rad].
  double same_translation = 0.5;
  double same_rotation = 0.15;
};

struct SearchMode {
  SE2 pose;
  double score = 0.0;  ///< mean likelihood of the points, in [0, 1]
};

/// The poses in the window at which the points agree best with the field, best first, one for each
/// mode, by branch and bound over squares of translations. Each is a cell of the field and a step
/// of the angle away from the true maximum at most. If the budget does not suffice, the modes found
/// so far; of more than `max_modes`, the best. Nothing tells of those that are left out.
std::vector<SearchMode> search_poses(const std::vector<Eigen::Vector2d>& points,
                                     const LikelihoodField& field, const SearchWindow& window,
                                     const SearchOptions& options = {});

}  // namespace hybrid
