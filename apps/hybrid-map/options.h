// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, the hybrid mapping authors

#pragma once

#include <optional>
#include <string>
#include <vector>

#include "mrpt_plugins/bridge/provenance.h"

namespace hybrid {

/// What the command line asks for.
struct Options {
  std::string command;            ///< info, check, export, join or prune
  std::vector<std::string> maps;  ///< one; for join two or more
  bool json = false;
  std::string output;          ///< folder of export, map file of join
  std::vector<double> origin;  ///< latitude, longitude, direction [deg]
  bool pictures = true;
  std::vector<int> sessions;  ///< to be removed
  bool vanished = false;      ///< landmarks that are not there any more are to be removed
  double odds = 1e4;          ///< evidence needed to join
  Provenance provenance;
};

/// Parses the command line. Returns nothing when the program is to end at once, as after --help,
/// with `exit_code` set; what to say has then been said.
std::optional<Options> parse_options(int argc, char** argv, int& exit_code);

}  // namespace hybrid
