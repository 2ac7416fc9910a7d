// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, the hybrid mapping authors

#pragma once

#include <optional>
#include <string>
#include <vector>

#include "libhybrid/maps/map_record.h"
#include "mrpt_plugins/bridge/output_directory.h"
#include "mrpt_plugins/mapping/map_result.h"
#include "mrpt_plugins/mapping/mapper.h"
#include "mrpt_plugins/mapping/path_archive.h"
#include "mrpt_plugins/session/truth.h"

namespace hybrid {

/// Writes landmarks.csv, landmarks.json, graph.g2o and steps.csv. Returns warnings for the user.
/// Throws where a file cannot be written.
std::vector<std::string> write_map(const OutputDirectory& out, const MapResult& result,
                                   const Backend& backend);

/// Writes map.geojson where it is known where on earth the map is: by `given`, or else by fixes.
/// Returns what is to be said of that.
std::vector<std::string> write_globe(const OutputDirectory& out, const MapResult& result,
                                     const std::optional<MapOrigin>& given);

/// Writes trajectory.tum and trajectory_dead_reckoning.tum, by the keyframes of the `whole` and
/// what is between them, and, where there is a true path, trajectory_truth.tum, the true poses at
/// the keyframes in the frame of the map; of several robots, each in a folder of its name.
void write_paths(const OutputDirectory& out, const std::vector<RobotPart>& parts,
                 const PathArchive& paths, const MapResult& whole,
                 const std::vector<Truth>& truths);

/// Writes trajectory_covariances.csv; of several robots, each in a folder of its name.
void write_covariances(const OutputDirectory& out, const std::vector<RobotPart>& parts);

/// Draws map and steps in a format.
void write_pictures(const OutputDirectory& out, PictureFormat format, const MapResult& result,
                    const GroundTruth& truth);

/// Draws "error", the error of position over time, where there is a true path; of several
/// robots, each in a folder of its name.
void write_error_plots(const OutputDirectory& out, PictureFormat format,
                       const std::vector<RobotPart>& parts, const std::vector<Truth>& truths);

}  // namespace hybrid
