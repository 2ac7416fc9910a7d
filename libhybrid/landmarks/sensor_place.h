// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, the hybrid mapping authors
#pragma once

#include "libhybrid/core/spatial_values.h"
#include "libhybrid/core/values.h"
#include "libhybrid/detections/detection.h"

namespace HYBRID_API hybrid {

/// Where a sensor is on its robot: by the estimate where that is calibrated and among the values,
/// else by the log.
inline Eigen::Isometry3d sensor_place(const DetectionFrame& sensor, const Values& values) {
  const bool is_estimated = sensor.calibrated && values.contains(*sensor.calibrated);
  return is_estimated ? isometry_at(values, *sensor.calibrated) : sensor.T_robot_sensor;
}

/// A sensor in the map, seen from where its robot is; in the plane what it is there.
inline Eigen::Isometry3d sensor_pose(const Eigen::Isometry3d& T_map_robot,
                                     const DetectionFrame& sensor, const Values& values,
                                     bool is_3d) {
  const Eigen::Isometry3d T = compose(T_map_robot, sensor_place(sensor, values));
  return is_3d ? T : to_isometry(to_se2(T));
}

}  // namespace hybrid
