// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, the hybrid mapping authors

#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "libhybrid/methods/robust_methods.h"
#include "mrpt_plugins/bridge/provenance.h"
#include "mrpt_plugins/drawing/image.h"

namespace hybrid {

/// Options of the command line.
struct Options {
  Provenance provenance;  ///< version and command
  std::string graph;
  std::string method;  ///< of robust_methods(); empty: not given
  bool online = false;
  std::string start = "auto";  ///< or "file", "odometry", "chordal", "tree"
  std::string trusted;         ///< "all", "odometry", or a file of pairs 'i j'; empty: see --help
  std::optional<std::uint64_t> shuffle;  ///< seed of the order of hypotheses
  std::string truth;                     ///< file; empty if unknown
  std::string labels;                    ///< file of true closures; empty if unknown
  MethodOptions methods;                 ///< settings of the methods
  SolverOptions solver;                  ///< of a batch with all closures
  std::vector<std::string> warnings;     ///< about deprecated names
  bool pictures = true;
  PictureFormat picture_format = PictureFormat::kPng;
  bool certify = false;
  bool repair_information = false;  ///< if it is not positive definite
  bool report = false;
  std::string output = "hybrid-pgo-out";
};

/// Whether all closures are trusted.
bool trusts_all(const Options& options);

/// Parses the command line, and reads the INI that it names. Returns nothing, with `exit_code` set,
/// if the program is to end at once, as after --help; the text for the user has then been printed.
/// Throws Error for an invalid INI.
std::optional<Options> parse_options(int argc, char** argv, int& exit_code);

}  // namespace hybrid
