// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, the hybrid mapping authors

#pragma once

#include <cstddef>
#include <cstdint>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "libhybrid/geometry/eigen.h"
#include "mrpt_plugins/mapping/map_change.h"

namespace HYBRID_API hybrid {

/// The history of a run: what was done at which keyframe, in order. Sightings are known by their
/// place in `sightings`, over all plugins.
struct RunRecord {
  struct Sighting {
    int keyframe = 0;
    SightingEvent event;
    std::optional<std::int64_t> landmark;  ///< by now, after decisions, merges and removals
    Eigen::VectorXd residual;  ///< measured less expected at the last estimate [m, rad]; or empty
    double chi_square = 0;     ///< of that, by the noise of the sensor
  };
  struct Association {
    int keyframe = 0;
    AssociationEvent event;
  };
  struct Decision {
    int keyframe = 0;
    DecisionEvent event;
  };
  struct Merge {
    int keyframe = 0;
    MergeEvent event;
  };
  struct Change {
    int keyframe = 0;
    std::vector<double> objectives;  ///< after every half-step
    std::vector<Flip> flipped;
    std::string refused;
  };
  struct Belief {
    int keyframe = 0;
    std::int64_t landmark = 0;
    std::vector<double> probabilities;  ///< by class
  };
  struct Life {  ///< of a landmark
    int keyframe = 0;
    std::int64_t landmark = 0;
    bool born = true;  ///< else it went
  };
  struct Snapshot {  ///< the estimate after a keyframe
    int keyframe = 0;
    int every = 1;                      ///< the path holds poses 0, every, 2 every ..
    std::vector<Eigen::Vector3d> path;  ///< .. and the newest one
    std::vector<std::pair<std::int64_t, Eigen::Vector3d>> landmarks;
  };

  std::vector<Sighting> sightings;
  std::vector<Association> associations;
  std::vector<Decision> decisions;
  std::vector<Merge> merges;
  std::vector<Change> changes;
  std::vector<Belief> beliefs;
  std::vector<Life> lives;
  std::vector<Snapshot> snapshots;
  int concluded = 0;  ///< number of changes that came before the last keyframe was done
};

}  // namespace hybrid
