// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, the hybrid mapping authors

#pragma once

#include <memory>
#include <string>
#include <vector>

#include "mrpt_plugins/bridge/provenance.h"
#include "mrpt_plugins/drawing/image.h"

namespace HYBRID_API hybrid {

class ParsedLogs;

/// A robot of several, as the command line names it.
struct RequestedRobot {
  std::string name, rawlog, truth_path;  ///< the files override the INI where not empty
};

/// What a replay is asked to do, beside what its INI says.
struct ReplayRequest {
  Provenance provenance;  ///< version and command; the replay adds inputs and configuration
  std::string config;     ///< the INI
  /// Override the INI where not empty. A rawlog "-" is standard input, mapped as it comes.
  std::string rawlog, truth_path, truth_map;
  std::vector<RequestedRobot> robots;         ///< where there are several
  std::vector<std::string> plugin_libraries;  ///< loaded already; the parser of rawlogs loads them
  std::vector<std::string> settings;          ///< section.key=value, instead of what the INI says
  std::string output = "hybrid-replay-out";
  std::string map;       ///< map file, instead of that of the INI
  std::string map_mode;  ///< auto, build, extend, localize; empty: as the INI
  bool resume = false;   ///< go on with the session that was interrupted
  bool pictures = true;
  PictureFormat picture_format = PictureFormat::kPng;  ///< of those in the plane
  bool events = false;                                 ///< write events.jsonl
  bool report = false;                                 ///< write report.html, and events.jsonl
  bool stream = false;                                 ///< tell every keyframe as a line of JSON
  int frames = 0;            ///< pictures of the growing map, each a file; 0: none
  bool cross_check = false;  ///< map halves of the detections apart and compare them
  /// Logs that were parsed before, where they may be read several times; null: they are not kept.
  std::shared_ptr<ParsedLogs> parsed = nullptr;
};

}  // namespace hybrid
