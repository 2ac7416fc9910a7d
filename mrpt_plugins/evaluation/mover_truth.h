// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, the hybrid mapping authors

#pragma once

#include <cstddef>
#include <cstdint>
#include <map>
#include <string>
#include <utility>
#include <vector>

#include "libhybrid/landmarks/association_decision.h"
#include "mrpt_plugins/evaluation/trajectory_metrics.h"
#include "mrpt_plugins/mapping/map_result.h"

namespace HYBRID_API hybrid {

/// Reads `step,id,x,y,z`: where the thing of this true id, which moves, was at a step of the log
/// [m]. Throws Error with file:line for anything else, and for a thing that is in two places.
TrueMovers read_true_movers(const std::string& path);

/// How well what moves was told from what stands, and followed.
struct MoverReport {
  std::size_t things = 0;           ///< movers of the map
  std::size_t sightings = 0;        ///< measurements of things that really move
  std::size_t kept_out = 0;         ///< of them, those that are of no landmark
  std::size_t followed = 0;         ///< of them, those that are of a mover
  std::size_t false_sightings = 0;  ///< measurements of things that really stand, but of a mover
  std::size_t states = 0;           ///< of movers, compared with the truth
  double mean_m = 0, max_m = 0;     ///< errors of their positions in the map
  double relative_mean_m = 0;       ///< of those as seen from the robot, whose own error is out

  double kept_out_share() const {
    return static_cast<double>(kept_out) / static_cast<double>(sightings);
  }
};

/// What the movers of a map are compared with.
struct MoverTruth {
  const TrueMovers& movers;
  std::vector<std::size_t> rows;     ///< step of the log of each keyframe
  std::map<double, PosePair> poses;  ///< of the robot, by time; those that are known
  /// From the map to the truth: what aligns the path.
  mrpt::poses::CPose3D T_truth_map;
};

/// Compares a mover with the true one that most of its measurements are of; `decisions` are of all
/// measurements.
MoverReport mover_report(const std::vector<AssociationDecision>& decisions,
                         const std::vector<MoverEstimate>& movers, const MoverTruth& truth);

}  // namespace hybrid
