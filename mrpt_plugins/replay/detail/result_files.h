// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, the hybrid mapping authors

#pragma once

#include <string>
#include <vector>

#include "mrpt_plugins/bridge/output_directory.h"
#include "mrpt_plugins/mapping/map_result.h"
#include "mrpt_plugins/mapping/mapper.h"
#include "mrpt_plugins/replay/detail/truth.h"

namespace hybrid {

/// Writes trajectory.tum, trajectory_dead_reckoning.tum, landmarks.csv, landmarks.json, graph.g2o
/// and steps.csv. Returns warnings for the user. Throws where a file cannot be written.
std::vector<std::string> write_texts(const OutputDirectory& out, const MapResult& result,
                                     const Backend& backend);

/// Writes trajectory_truth.tum, the true poses at the times of trajectory.tum in the frame of the
/// map, if there is a true path.
void write_true_path(const OutputDirectory& out, const MapResult& result, const Truth& truth,
                     const std::vector<std::size_t>& log_rows);

/// Draws map.png, map_3d.png, steps.png and scene.3Dscene; returns warnings for the user.
std::vector<std::string> write_pictures(const OutputDirectory& out, const MapResult& result,
                                        const GroundTruth& truth);

/// Draws error.png, the error of position over time, if there is a true path.
void write_error_plot(const OutputDirectory& out, const MapResult& result, const Truth& truth,
                      const std::vector<std::size_t>& log_rows);

}  // namespace hybrid
