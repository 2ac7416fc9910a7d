// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, the hybrid mapping authors

#pragma once

#include <string>
#include <vector>

#include "mrpt_plugins/bridge/output_directory.h"
#include "mrpt_plugins/bridge/timed_pose.h"
#include "mrpt_plugins/mapping/cloud_follower.h"
#include "mrpt_plugins/mapping/grid_map.h"
#include "mrpt_plugins/mapping/scan_archive.h"

namespace HYBRID_API hybrid {

/// The scans of one keyframe.
struct KeyframeScans {
  std::size_t keyframe = 0;
  std::vector<const LaserScan*> scans;
};

/// The keyframes, with their own scans, of which a map is drawn: those that are at least 0.2 m or
/// 10 degrees from the one before of the same robot, so that a robot that stands does not outweigh
/// one that drives.
std::vector<KeyframeScans> drawn_keyframes(const ScanArchive& archive, const Trajectory& keyframes);

/// MRPT's occupancy grid of these scans with cells of 0.05 m, or coarser by a power of two where
/// there would be more than `most_cells` of them. Rays count up to 30 m; one without a return
/// tells nothing. Scans of sensors that are not level are left out, as MRPT does. Empty where no
/// ray has a return.
GridMap draw_grid(const std::vector<KeyframeScans>& scans, const Trajectory& keyframes,
                  double most_cells = 64e6);

/// The grid as a picture in PGM form, map.pgm of ROS: 254 free, 0 occupied, 205 unknown.
std::string grid_pgm(const GridMap& grid);
/// What map_server and nav2 read beside it; `pgm` is its name.
std::string grid_yaml(const GridMap& grid, const std::string& pgm);

/// Writes an MRPT .simplemap: keyframes as poses with covariances, each with its scans. Programs of
/// MRPT such as sm2gridmap make maps of it. `covariances` are those of the keyframes in the tangent
/// of the pose, 3x3 or 6x6; an empty one becomes zero.
void write_simple_map(const OutputDirectory& out, const std::string& name,
                      const std::vector<KeyframeScans>& scans, const Trajectory& keyframes,
                      const std::vector<Eigen::MatrixXd>& covariances);
/// The same of what clouds saw along stretches of the path, each at its anchor.
void write_simple_map(const OutputDirectory& out, const std::string& name,
                      std::vector<LocalView> views, const Trajectory& keyframes,
                      const std::vector<Eigen::MatrixXd>& covariances);

}  // namespace hybrid
