// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, the hybrid mapping authors

#pragma once

#include <array>
#include <optional>
#include <string>

#include "libhybrid/maps/map_record.h"
#include "mrpt_plugins/bridge/ini_file.h"
#include "mrpt_plugins/mapping/motion.h"
#include "mrpt_plugins/settings/replay_request.h"

namespace HYBRID_API hybrid {

/// Where a robot starts.
struct StartOptions {
  std::vector<double> pose;  ///< x y yaw or x y z yaw pitch roll [m, rad]; empty: not known
  double sigma_m = 0, sigma_rad = 0;
};

/// What a replay does with a map file.
struct MapOptions {
  std::string file;                 ///< empty: none
  std::string mode = "auto";        ///< auto, build, extend or localize
  int commit_every = 10;            ///< keyframes
  double odds = 1e4;                ///< evidence that a place needs
  std::optional<MapOrigin> origin;  ///< as stated by hand
  StartOptions start;

  bool localizes() const { return mode == "localize"; }
};

/// Reads those keys of [map] that are about the file; the command line goes first.
MapOptions read_map_options(IniFile& ini, const ReplayRequest& request);

/// The pose that the options give, if they do.
std::optional<KnownStart> given_start(const StartOptions& options, bool is_3d);

}  // namespace hybrid
