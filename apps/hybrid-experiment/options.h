// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, the hybrid mapping authors

#pragma once

#include <optional>
#include <string>
#include <vector>

#include "mrpt_plugins/bridge/provenance.h"

namespace hybrid {

/// Options of the command line.
struct Options {
  Provenance provenance;  ///< version and command
  std::string config;
  std::vector<std::string> settings;  ///< section.key=value, instead of those of the INI
  std::string output = "hybrid-experiment-out";
  std::string data_dir;  ///< overrides the INI unless empty
  int jobs = 0;          ///< overrides the INI if positive
  bool summary_only = false;
  bool retry = false;  ///< rerun trials that failed, crashed or timed out
  bool report = false;
  bool print_config = false;
};

/// Parses the command line. Returns nothing, with `exit_code` set, if the program is to end at
/// once, as after --help; the text for the user has then been printed.
std::optional<Options> parse_options(int argc, char** argv, int& exit_code);

}  // namespace hybrid
