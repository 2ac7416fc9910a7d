// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, the hybrid mapping authors
#pragma once

#include <vector>

#include "libhybrid/core/noise.h"
#include "libhybrid/objects/object_sightings.h"

namespace HYBRID_API hybrid {

/// Noise of the true sightings of one object, standard deviations.
struct SightingNoise {
  double across_m = 0.01;   ///< of its position, across the line of sight, per axis
  double along_m = 0.01;    ///< along the line of sight
  double angle_rad = 0.03;  ///< of its rotation, per axis
  /// How many sightings tell as much as one: errors that last over frames are seen once.
  double repetitions = 1.0;

  /// Of a sighting T_camera_object, in the tangent of the object.
  Noise of(const SE3& sighting) const;
};

/// Noise of an ObjectSequence.
struct ObjectNoise {
  double step_m = 0.0001;  ///< odometry, from frame to frame, standard deviations per axis
  double step_rad = 0.0001;
  bool odometry_measured = false;        ///< else what was stated
  std::vector<SightingNoise> sightings;  ///< by object; as stated where too few were to be measured
  std::vector<bool> sightings_measured;
};

/// Measures the noise of a sequence from pairs of frames, without a map: an object seen twice
/// should be where odometry says. Wrong sightings are trimmed. What several objects have in common
/// grows by the noise of odometry; it is measured where that is certain to three standard
/// deviations, and is no more than the least growth of any object. The rest is noise of the
/// sightings: their scatter over up to 32 frames, and, from the scatter over longer times, how long
/// errors last. No noise is taken to be less than a tenth of the one stated.
ObjectNoise measure_noise(const ObjectSequence& sequence, const ObjectNoise& stated);

}  // namespace hybrid
