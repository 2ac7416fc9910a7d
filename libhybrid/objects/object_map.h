// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, the hybrid mapping authors
#pragma once

#include <vector>

#include "libhybrid/closures/mixture_graph.h"
#include "libhybrid/closures/problem.h"
#include "libhybrid/core/key_letters.h"
#include "libhybrid/objects/object_noise.h"
#include "libhybrid/objects/object_sightings.h"

namespace HYBRID_API hybrid {

struct ObjectMapOptions {
  /// What is stated of the noise of an ObjectSequence, standard deviations per axis.
  double step_m = 0.0001;  ///< odometry, from frame to frame
  double step_rad = 0.0001;
  double sighting_m = 0.01;  ///< a true sighting
  double sighting_rad = 0.03;
  MixtureOptions mixture;
  ObjectMapOptions() {
    mixture.outlier_variance = 10.0;
    mixture.flat = true;
  }
};

/// The camera in frame i, and object k.
inline Key camera_key(std::size_t frame) {
  return {key_letter::kPose, frame};
}
inline Key object_key(std::size_t object) {
  return {key_letter::kObject, object};
}

/// The noise that the options state. Throws Error for deviations that are not positive.
ObjectNoise stated_noise(const ObjectSequence& sequence, const ObjectMapOptions& options = {});

/// Objects as landmarks in SE(3): odometry and a prior on the first camera pose are trusted, every
/// sighting is a candidate, object by object in the order of frames. The initial pose of an object
/// is the one of its sightings, by the odometry, that agrees best with all others under the
/// mixture. Objects without a sighting are left out.
RobustProblem object_problem(const ObjectSequence& sequence, const ObjectNoise& noise,
                             const ObjectMapOptions& options = {});
/// With the noise that the options state.
RobustProblem object_problem(const ObjectSequence& sequence, const ObjectMapOptions& options = {});

/// Alternating minimisation over poses, objects and the switch of each sighting: from the initial
/// values and from those that the kernels of Huber and Cauchy lead to; the lowest objective counts.
RobustResult solve_objects(const RobustProblem& problem, const ObjectMapOptions& options = {});

/// For comparison: all sightings under a robust kernel instead of switches, from the same initial
/// values.
RobustResult solve_objects(const RobustProblem& problem, const Loss& loss,
                           const ObjectMapOptions& options = {});

/// The path and the objects once more, with the decisions of `decided` about each sighting, each
/// object's sightings counting as many times less as they repeat each other.
RobustResult count_repetitions(const ObjectSequence& sequence, const ObjectNoise& noise,
                               const RobustResult& decided);

/// Root mean square error of the camera positions after the best rigid alignment, and the errors of
/// each object in the aligned frame; NaN for an object left out or without truth.
struct ObjectMapErrors {
  SE3 T_world_map;                          ///< the alignment
  std::vector<std::optional<SE3>> objects;  ///< true poses T_world_object
  double trajectory_m = 0.0;
  std::vector<double> object_m, object_deg;
};

/// Compares with the truth of the sequence. Throws Error if it has none for the camera.
ObjectMapErrors object_map_errors(const ObjectSequence& sequence, const Values& values);

}  // namespace hybrid
