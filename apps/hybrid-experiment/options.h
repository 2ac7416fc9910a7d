// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, the hybrid mapping authors

#pragma once

#include <optional>
#include <string>

#include "mrpt_plugins/bridge/provenance.h"

namespace hybrid {

/// What the command line asks for.
struct Options {
  Provenance provenance;  ///< version and command
  std::string config;
  std::string output = "hybrid-experiment-out";
  std::string data_dir;  ///< overrides the INI where not empty
  int jobs = 0;          ///< overrides the INI where positive
  bool summary_only = false;
  bool retry = false;  ///< run trials again that failed, crashed or took too long
  bool report = false;
  bool print_config = false;
};

/// Parses the command line. Returns nothing when the program is to end at once, as after --help,
/// with `exit_code` set; what to say has then been said.
std::optional<Options> parse_options(int argc, char** argv, int& exit_code);

}  // namespace hybrid
