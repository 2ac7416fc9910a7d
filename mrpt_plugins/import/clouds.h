// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, the hybrid mapping authors

#pragma once

#include <cstddef>
#include <string>
#include <vector>

#include "mrpt_plugins/import/log_writer.h"

namespace HYBRID_API hybrid {

/// A folder of point clouds of a lidar or a depth camera, one file each.
struct CloudsOptions {
  std::string folder;
  /// Poses by which the motions between clouds are known; empty: none are.
  std::string odometry;
  std::string truth;  ///< True poses; empty: none.
  /// Whether these poses are of a camera that looks along z, as those of KITTI. Poses beside depth
  /// images are, unless there is a sensor pose.
  bool camera_odometry = false, camera_truth = false;
  double period = 0.1;  ///< between clouds, where no file tells times [s]
  /// On the robot, x y z yaw pitch roll [m, rad]. Empty: poses are those of the sensor.
  std::vector<double> sensor_pose;
  std::size_t most_points = 40000;      ///< of a cloud, thinned to one point a voxel; 0: all
  double max_range = 0;                 ///< points farther away are dropped [m]; 0: none
  double focal = 0;                     ///< focal length of depth images [pixels]
  double center_u = -1, center_v = -1;  ///< principal point; below 0: the middle of the image
  double depth_unit = 0.001;            ///< of depth images [m]
  /// Noise of the odometry [m per sqrt(m), rad per sqrt(m)].
  double walk_translation = 0.05, walk_rotation = 0.02;
};

/// Converts the clouds of a folder, in the natural order of their names, into a log in space with
/// one step for each, a CObservationPointCloud "LIDAR" or "DEPTH", or a CObservationVelodyneScan
/// where points have times. Clouds are KITTI's F.bin, F.pcd and F.ply in axes of a robot, or depth
/// images F.png of 16 bits, which are turned into these axes. Poses are one for each cloud
/// (detail/pose_rows.h tells their forms), and tell times where they have them. Where names are
/// times, as 1305031102.160407.png, these are the order, and poses of another number are
/// interpolated. One cloud at a time is in memory.
///
/// A cloud that cannot be read is dropped and counted, and noted with its file; one without points
/// stays an empty one. Throws Error for a folder without clouds, and for another number of poses
/// than clouds.
ImportReport import_clouds(const CloudsOptions& options, const std::string& output);

}  // namespace hybrid
