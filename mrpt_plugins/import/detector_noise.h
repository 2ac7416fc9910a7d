// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, the hybrid mapping authors

#pragma once

#include "mrpt_plugins/observations/classed_bearing_range.h"

namespace HYBRID_API hybrid {

/// What the detections of a sensor scatter by: sigma of the range hypot(range, range_share r), of
/// the angles hypot(bearing, across / r).
struct DetectorNoise {
  double range = 0;        ///< [m]
  double range_share = 0;  ///< [m per m of range]
  double bearing = 0;      ///< [rad]
  double across = 0;       ///< Of the point that is seen of an object [m].
};

/// Gives a detection its sigmas.
void set_noise(const DetectorNoise& noise, CObservationClassedBearingRange::Detection& detection);

}  // namespace hybrid
