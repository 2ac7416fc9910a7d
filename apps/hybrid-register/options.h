// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, the hybrid mapping authors

#pragma once

#include <optional>
#include <string>

#include "mrpt_plugins/bridge/provenance.h"

namespace hybrid {

/// Options of the command line.
struct Options {
  Provenance provenance;  ///< version and command
  std::string source, target;
  std::string metric = "surface";
  std::string start;  ///< file with a 4x4 matrix; empty: the identity
  bool search = true;
  int threads = 0;
  std::string unit;
  std::string output = "hybrid-register-out";
};

/// Parses the command line. Returns nothing, with `exit_code` set, if the program is to end at
/// once, as after --help; the text for the user has then been printed.
std::optional<Options> parse_options(int argc, char** argv, int& exit_code);

}  // namespace hybrid
