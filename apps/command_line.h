// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, the hybrid mapping authors

#pragma once

#include <CLI/CLI.hpp>
#include <string>

#include "apps/exit_code.h"
#include "apps/version.h"
#include "mrpt_plugins/bridge/provenance.h"

namespace hybrid {

/// The option -o of a program that writes a folder.
inline void add_output_folder(CLI::App& app, std::string& output) {
  app.add_option("-o,--output", output, "folder for the results, created if absent")
      ->type_name("OUT")
      ->capture_default_str();
}

/// Whether the command line was parsed and the program is to go on. If not, as after --help,
/// --version or an error, what to say has been said, and `exit_code` is set.
inline bool parse_command_line(CLI::App& app, int argc, char** argv, int& exit_code) {
  app.set_version_flag("--version", app.get_name() + " " + program_version(),
                       "print the version and exit");
  try {
    app.parse(argc, argv);
    return true;
  } catch (const CLI::ParseError& e) {
    exit_code = app.exit(e) == 0 ? kExitOk : kExitFailure;
    return false;
  }
}

/// Version and command line, for summary.json.
inline Provenance provenance_of(int argc, char** argv) {
  Provenance provenance;
  provenance.version = program_version();
  provenance.command.assign(argv, argv + argc);
  return provenance;
}

}  // namespace hybrid
