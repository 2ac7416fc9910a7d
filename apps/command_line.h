// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, the hybrid mapping authors

#pragma once

#include <CLI/CLI.hpp>
#include <string>

#include "apps/exit_code.h"
#include "mrpt_plugins/bridge/provenance.h"

namespace hybrid {

/// The option -o of a program that writes a folder.
void add_output_folder(CLI::App& app, std::string& output);

/// Whether the command line was parsed and the program is to go on. If not, as after --help,
/// --version or an error, what to say has been said, and `exit_code` is set. An option or command
/// that is not known is named, with the one that is nearest to it.
bool parse_command_line(CLI::App& app, int argc, char** argv, int& exit_code);

/// Version and command line, for summary.json.
Provenance provenance_of(int argc, char** argv);

}  // namespace hybrid
