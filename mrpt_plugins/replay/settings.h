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
  std::unique_ptr<Backend> backend;
};

/// Declares and reads all sections, and creates the plugins. While `ini` documents, the sections of
/// all registered plugins are declared, and no log needs to be named. Throws Error for anything
/// unknown or wrong.
ReplaySettings read_settings(IniFile& ini, const ReplayRequest& request);

/// All sections and keys as a valid INI with comments: those of the INI given, or without one those
/// of every registered plugin with the defaults.
std::string config_text(const ReplayRequest& request);

}  // namespace hybrid
