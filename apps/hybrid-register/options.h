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
  std::string source, target;
  std::string metric = "surface";
  std::string start;  ///< file with a 4x4 matrix; empty: the identity
  bool search = true;
  int threads = 0;
  std::string unit;
  std::string output = "hybrid-register-out";
};

/// Parses the command line. Returns nothing when the program is to end at once, as after --help,
/// with `exit_code` set; what to say has then been said.
std::optional<Options> parse_options(int argc, char** argv, int& exit_code);

}  // namespace hybrid
