// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, the hybrid mapping authors

#pragma once

#include <CLI/CLI.hpp>
#include <string>
#include <vector>

#include "apps/exit_code.h"
#include "mrpt_plugins/bridge/provenance.h"
#include "mrpt_plugins/drawing/image.h"

namespace hybrid {

/// Adds the option --set of a program that reads an INI.
void add_settings(CLI::App& app, std::vector<std::string>& settings);

/// Adds the option -o of a program that writes a folder.
void add_output_folder(CLI::App& app, std::string& output);

/// What is wrong with the name of a file that an option names, or "".
std::string fault_of_file_name(const std::string& name);

/// Adds the option --picture-format of a program that draws.
void add_picture_format(CLI::App& app, PictureFormat& format);

/// Adds a flag that did something once: it is not in the help, and given it only says so.
void add_retired_flag(CLI::App& app, const std::string& name);

/// Whether the program is to continue after parsing. If not, as after --help, --version or an
/// error, the text for the user has been printed and `exit_code` is set. For an unknown option or
/// command, the message suggests the nearest one.
bool parse_command_line(CLI::App& app, int argc, char** argv, int& exit_code);

/// Version and command line, for summary.json.
Provenance provenance_of(int argc, char** argv);

}  // namespace hybrid
