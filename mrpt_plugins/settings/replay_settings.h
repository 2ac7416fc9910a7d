// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, the hybrid mapping authors

#pragma once

#include <Eigen/Core>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "mrpt_plugins/bridge/geodesy.h"
#include "mrpt_plugins/input/keyframe_source.h"
#include "mrpt_plugins/input/log_correction.h"
#include "mrpt_plugins/mapping/mapper.h"
#include "mrpt_plugins/settings/map_options.h"
#include "mrpt_plugins/settings/replay_request.h"

namespace HYBRID_API hybrid {

/// What belongs to one robot of a replay.
struct RobotSettings {
  std::string name;  ///< empty where there is but one
  std::string rawlog, truth_path, truth_associations, truth_modes, truth_fixes;
  std::size_t truth_step =
      0;  ///< of the log, that the first row of a true path without times is of
  Eigen::Vector3d truth_point = Eigen::Vector3d::Zero();  ///< on the robot [m]
  SourceOptions source;
  StartOptions start;
  std::vector<std::string> plugins;  ///< names of those that see what it observes; empty: all
  RobotOptions options;              ///< for the mapper
  LogFindings findings;              ///< what was measured of its log before
};

/// Everything a replay needs, from INI and command line.
struct ReplaySettings {
  std::string title, truth_map, truth_movers;
  /// Place to whose east, north and up the true paths refer.
  std::optional<GeodeticPoint> truth_datum;
  double match_radius = 1.0;  ///< between a landmark of the map and a true one [m]
  std::vector<RobotSettings> robots;
  bool sightings = true;   ///< of robots by robots are used
  double huber_width = 3;  ///< of these [sigmas]; 0: none
  MapOptions map;
  std::vector<std::shared_ptr<MappingPlugin>> plugins;
  std::vector<std::string> chosen;  ///< their names, where they were chosen by what the log holds
  bool keeps_scans = false;         ///< for the outputs
  std::unique_ptr<Backend> backend;
};

/// The INI of a request, or an empty one where it names none.
std::unique_ptr<IniFile> open_config(const ReplayRequest& request);

/// Declares and reads all sections, and creates the plugins; where [plugins] classes = auto, which
/// is the default, the log is read once to choose them. Throws Error for anything unknown or wrong.
ReplaySettings read_settings(IniFile& ini, const ReplayRequest& request);

/// The request with the plugins that were chosen for it, so that its log is not read once more to
/// choose them.
ReplayRequest with_chosen_plugins(ReplayRequest request, const ReplaySettings& settings);

/// All sections and keys as a valid INI with comments, which reads back from any folder: those of
/// the plugins that the INI names, or of all where they are chosen by the log.
std::string config_text(const ReplayRequest& request);

}  // namespace hybrid
