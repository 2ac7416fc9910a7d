// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, the hybrid mapping authors

#pragma once

#include <optional>

#include "mrpt_plugins/settings/replay_request.h"

namespace hybrid {

/// What the command line asks for.
struct Options {
  ReplayRequest request;
  bool print_config = false;
  bool strict = false;  ///< a result with a bad verdict about itself is not all well
};

/// Parses the command line. Returns nothing when the program is to end at once, as after --help,
/// with `exit_code` set; what to say has then been said.
std::optional<Options> parse_options(int argc, char** argv, int& exit_code);

}  // namespace hybrid
