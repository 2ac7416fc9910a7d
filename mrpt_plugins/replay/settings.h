// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, the hybrid mapping authors

#pragma once

#include <Eigen/Core>
#include <memory>
#include <string>
#include <vector>

#include "mrpt_plugins/input/keyframe_source.h"
#include "mrpt_plugins/mapping/backend.h"
#include "mrpt_plugins/mapping/calibration.h"
#include "mrpt_plugins/mapping/mapping_plugin.h"
#include "mrpt_plugins/mapping/motion.h"
#include "mrpt_plugins/replay/map_options.h"
#include "mrpt_plugins/replay/replay_request.h"

namespace HYBRID_API hybrid {

/// Everything a replay needs, from INI and command line.
struct ReplaySettings {
  std::string title;
  std::string rawlog, truth_path, truth_map, truth_associations, truth_modes;
  Eigen::Vector3d truth_point = Eigen::Vector3d::Zero();  ///< on the robot [m]
  double match_radius = 1.0;  ///< between a landmark of the map and a true one [m]
  SourceOptions source;
  MotionOptions motion;
  CalibrationOptions calibration;
  MapOptions map;
  std::vector<std::shared_ptr<MappingPlugin>> plugins;
  std::vector<std::string> chosen;  ///< their names, where they were chosen by what the log holds
  std::unique_ptr<Backend> backend;
};

/// The INI of a request, or an empty one where it names none.
std::unique_ptr<IniFile> open_config(const ReplayRequest& request);

/// Declares and reads all sections, and creates the plugins; where [plugins] classes = auto, which
/// is the default, the log is read once to choose them. Throws Error for anything unknown or wrong.
ReplaySettings read_settings(IniFile& ini, const ReplayRequest& request);

/// All sections and keys as a valid INI with comments, which reads back from any folder: those of
/// the plugins that the INI names, or of all where they are chosen by the log.
std::string config_text(const ReplayRequest& request);

}  // namespace hybrid
