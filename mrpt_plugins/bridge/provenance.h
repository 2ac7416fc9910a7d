// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, the hybrid mapping authors

#pragma once

#include <nlohmann/json_fwd.hpp>
#include <string>
#include <vector>

#include "mrpt_plugins/bridge/ini_file.h"

namespace HYBRID_API hybrid {

/// What a result was made of and by.
struct Provenance {
  struct Input {
    std::string path;
    std::string sha256;   ///< empty for what is no regular file
    std::string warning;  ///< "" or why the file may not be whole
  };

  std::string version;               ///< of the program
  std::vector<std::string> command;  ///< its name and arguments
  std::vector<Input> inputs;         ///< files
  IniFile::Settings configuration;   ///< settings in effect; empty without an INI

  /// Notes a file, once; an empty path is none. Throws SystemError if it cannot be read.
  void add_input(const std::string& path);
};

/// The fields that every summary.json starts with: status, message (where there is one), version,
/// command, inputs, configuration (where there is one).
nlohmann::ordered_json summary_start(const std::string& status, const std::string& message,
                                     const Provenance& provenance);

}  // namespace hybrid
