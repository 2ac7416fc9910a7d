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
  std::string input;
  std::string truth;  ///< of a log of ranges; empty: unknown
  std::string output = "hybrid-switching-out";
  // For a labelled series; columns count from 1.
  int label_column = 2;
  std::vector<int> angle_columns = {5};
  std::vector<int> value_columns;
  std::vector<int> path_columns = {3, 4};
  std::vector<std::string> names;
  int order = 2;
  int folds = 2;
  bool without_labels = false;
  bool pictures = true;
};

/// Parses the command line. Returns nothing, with `exit_code` set, if the program is to end at
/// once; the text for the user has then been printed.
std::optional<Options> parse_options(int argc, char** argv, int& exit_code);

}  // namespace hybrid
