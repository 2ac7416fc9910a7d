// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, the hybrid mapping authors

#pragma once

#include <string>
#include <vector>

#include "libhybrid/export.h"

namespace HYBRID_API hybrid {

/// How boxes in images become directions, and ranges where the height of a class is known.
struct ImageBoxOptions {
  double focal = 0;                          ///< Focal length [pixels].
  double center_u = -1, center_v = -1;       ///< Principal point [pixels]; below 0: the middle.
  double image_width = 0, image_height = 0;  ///< [pixels]; 0: not known.
  double period = 0;        ///< Between images [s]: image n is of n periods after `start`.
  double start = 0;         ///< [s]
  std::string frame_times;  ///< A table frame,time in place of both; empty: none.
  double min_score = 0;     ///< Boxes with less are dropped.
  std::vector<std::string> class_names;    ///< NUMBER=NAME.
  std::vector<std::string> class_heights;  ///< NAME=METRES.
  double sigma_height = 0.1;               ///< Of these heights, as a share.
  double sigma_pixels = 2;                 ///< Of the height of a box.
};

/// Satellite fixes as a comma-separated table.
struct FixTableOptions {
  /// Columns time and latitude, longitude [deg] and optional altitude [m]; or x, y and optional z
  /// (east, north, up) [m]; optional sigma of each horizontal axis [m], and quality as GGA numbers
  /// it (without: 1). Empty: no fixes.
  std::string table;
  /// Latitude, longitude [deg] and altitude [m] to which x, y and z are relative. Empty: they are
  /// relative to the first row, which is put to latitude and longitude 0, and the label of the
  /// sensor ends with _local.
  std::vector<double> datum;
  std::vector<double> antenna{0, 0, 0};  ///< On the robot: x y z [m].
};

/// Detections and odometry as comma-separated tables whose first row names the columns.
struct DetectionTablesOptions {
  /// Columns time, x, y, yaw or time, x, y, z, yaw, pitch, roll, or quaternions qx, qy, qz, qw in
  /// place of angles: odometry poses, [s], [m], [rad].
  std::string odometry;
  /// Columns time, yaw, and where they are measured range and pitch (positive: down), or time, x, y
  /// and z as the sensor sees them (ahead, left, up); optional class, score, id, true_id,
  /// sigma_range, sigma_yaw, sigma_pitch; or instead of class and score the probability of every
  /// class, p_NAME. With ranges and ids but no yaw, they are ranges to beacons. Or boxes in images:
  /// a folder of YOLO's text files, COCO results (.json), or det.txt of MOT. Empty: none, where
  /// there are fixes.
  std::string detections;
  std::vector<std::string> classes;  ///< Names; empty: those met in the table, sorted.
  double score = 1;  ///< Probability of the class of a detection where the table has none.
  std::vector<double> sensor_pose{0, 0, 0, 0, 0, 0};  ///< On the robot: x y z yaw pitch roll.
  double sigma_range = 0.1, sigma_bearing = 0.02;     ///< Defaults for tables without sigmas [m],
                                                      ///< [rad].
  double sigma_range_share = 0;                       ///< Added to sigma_range [m per m of range].
  double sigma_across = 0;  ///< Lateral sigma of the point seen of a thing, which near by turns its
                            ///< direction [m].
  double fov = 0;           ///< Full field of view in yaw [rad]; 0: unknown.
  /// Random walk of the odometry: along and across [m per sqrt(m)], heading [rad per sqrt(m)].
  double walk_translation = 0.05, walk_rotation = 0.02;
  ImageBoxOptions boxes;  ///< For detections that are boxes in images.
  FixTableOptions fixes;
};

}  // namespace hybrid
