// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, the hybrid mapping authors

#pragma once

#include <string>
#include <vector>

#include "mrpt_plugins/import/log_writer.h"

namespace HYBRID_API hybrid {

/// Detections and odometry as comma-separated tables whose first row names the columns.
struct DetectionTablesOptions {
  /// Columns time, x, y, yaw or time, x, y, z, yaw, pitch, roll: odometry poses, [s], [m], [rad].
  std::string odometry;
  /// Columns time, yaw and, if measured, range and pitch (positive: down). Optional columns: class,
  /// score, id, true_id, sigma_range, sigma_yaw, sigma_pitch.
  std::string detections;
  std::vector<std::string> classes;  ///< Class names; empty: those of the table, sorted.
  std::vector<double> sensor_pose{0, 0, 0, 0, 0, 0};  ///< On the robot: x y z yaw pitch roll.
  double sigma_range = 0.1, sigma_bearing = 0.02;     ///< Defaults for tables without sigmas [m],
                                                      ///< [rad].
  double fov = 0;  ///< Full field of view in yaw [rad]; 0: unknown.
  /// Random walk of the odometry: along and across [m per sqrt(m)], heading [rad per sqrt(m)].
  double walk_translation = 0.05, walk_rotation = 0.02;
};

/// Converts the tables into a log with one step per time of detections. The odometry is
/// interpolated. The score of a detection is the probability of its class; the other classes share
/// the rest equally. Detections before the first or after the last odometry pose are dropped.
ImportReport import_detection_tables(const DetectionTablesOptions& options,
                                     const std::string& output);

}  // namespace hybrid
