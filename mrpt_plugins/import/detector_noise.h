// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, the hybrid mapping authors

#pragma once

#include "mrpt_plugins/observations/classed_bearing_range.h"

namespace HYBRID_API hybrid {

/// Noise of detections: the sigma of a range r is hypot(range, range_share r), that of angles
/// hypot(bearing, across / r).
struct DetectorNoise {
  double range = 0;        ///< [m]
  double range_share = 0;  ///< [m per m of range]
  double bearing = 0;      ///< [rad]
  double across = 0;       ///< Lateral sigma of the detected point of an object [m].
};

/// Sets the sigmas of a detection by its range.
void set_noise(const DetectorNoise& noise, CObservationClassedBearingRange::Detection& detection);

}  // namespace hybrid
