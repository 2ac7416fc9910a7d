// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, the hybrid mapping authors

#pragma once

#include <nlohmann/json_fwd.hpp>
#include <string>
#include <vector>

#include "mrpt_plugins/bridge/ini_file.h"

namespace HYBRID_API hybrid {

/// Program, command and inputs of a result.
struct Provenance {
  struct Input {
    std::string path;
    std::string sha256;   ///< empty unless a regular file
    std::string warning;  ///< why the file may be incomplete, or ""
  };

  std::string version;               ///< of the program
  std::vector<std::string> command;  ///< its name and arguments
  std::vector<Input> inputs;         ///< files
  IniFile::Settings configuration;   ///< settings in effect; empty without an INI

  /// Adds a file once; ignores an empty path. Throws SystemError if it cannot be read.
  void add_input(const std::string& path);
};

/// The first fields of every summary.json: status, message (if any), version, command, inputs,
/// configuration (if any).
nlohmann::ordered_json summary_start(const std::string& status, const std::string& message,
                                     const Provenance& provenance);

}  // namespace hybrid
