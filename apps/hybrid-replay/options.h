// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, the hybrid mapping authors

#pragma once

#include <optional>
#include <string>
#include <vector>

#include "mrpt_plugins/output/provenance.h"

namespace hybrid {

/// What the command line asks for.
struct Options {
  Provenance provenance;  ///< version and command
  std::string config;
  std::string rawlog, truth_path, truth_map;  ///< override the INI where not empty
  std::vector<std::string> plugin_libraries;
  std::vector<std::string> settings;  ///< section.key=value, instead of what the INI says
  std::string output = "hybrid-replay-out";
  bool pictures = true;
  bool sparsity = false;
  int frames = 0;     ///< pictures of the growing map, each a file; 0: none
  std::string video;  ///< film of them; empty: none
  bool print_config = false;
};

/// Parses the command line. Returns nothing when the program is to end at once, as after --help,
/// with `exit_code` set; what to say has then been said.
std::optional<Options> parse_options(int argc, char** argv, int& exit_code);

}  // namespace hybrid
