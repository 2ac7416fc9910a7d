// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, the hybrid mapping authors

#pragma once

#include <optional>
#include <string>
#include <vector>

#include "libhybrid/maps/map_record.h"
#include "mrpt_plugins/bridge/provenance.h"

namespace hybrid {

/// Options of the command line.
struct Options {
  std::string command;            ///< info, check, export, join or prune
  std::vector<std::string> maps;  ///< one; two or more for join
  bool json = false;
  std::string output;          ///< folder of export, map file of join
  std::vector<double> origin;  ///< latitude, longitude, direction [deg]
  bool pictures = true;
  bool mcap = false;
  std::vector<int> sessions;        ///< to remove
  std::vector<std::string> robots;  ///< whose keyframes to remove
  bool vanished = false;            ///< remove landmarks that no longer exist
  double odds = 1e4;                ///< odds of a common place required to join
  Provenance provenance;
};

/// Parses the command line. Returns nothing, with `exit_code` set, if the program is to end at
/// once, as after --help; the text for the user has then been printed.
std::optional<Options> parse_options(int argc, char** argv, int& exit_code);

/// Each function runs a command, prints its report and returns the exit code. All throw Error.
int info(const Options& options);
int check(const Options& options);
int export_map(const Options& options);
int join(const Options& options);
int prune(const Options& options);

/// ", 4 local maps of laser scans", and of clouds; "" where a map has none.
std::string places_text(const MapRecord& map);

}  // namespace hybrid
