// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, the hybrid mapping authors

#include "mrpt_plugins/import/detector_noise.h"

#include <cmath>

namespace hybrid {

void set_noise(const DetectorNoise& noise, CObservationClassedBearingRange::Detection& detection) {
  const double r = detection.range;
  detection.std_range = static_cast<float>(std::hypot(noise.range, noise.range_share * r));
  detection.std_yaw = static_cast<float>(std::hypot(noise.bearing, noise.across / r));
  detection.std_pitch = detection.std_yaw;
}

}  // namespace hybrid
