// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, the hybrid mapping authors
#pragma once

#include "libhybrid/core/spatial_values.h"
#include "libhybrid/core/values.h"
#include "libhybrid/landmarks/detection.h"

namespace hybrid {

/// Where a sensor is on its robot: by the estimate where that is calibrated and among the values,
/// else by the log.
inline Eigen::Isometry3d sensor_place(const DetectionFrame& sensor, const Values& values) {
  const bool is_estimated = sensor.calibrated && values.contains(*sensor.calibrated);
  return is_estimated ? isometry_at(values, *sensor.calibrated) : sensor.T_robot_sensor;
}

}  // namespace hybrid
