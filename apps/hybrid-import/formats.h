// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, the hybrid mapping authors

#pragma once

#include <CLI/CLI.hpp>
#include <array>
#include <functional>
#include <string>

#include "mrpt_plugins/import/log_writer.h"

namespace hybrid {

/// Converts the input of the command line into a log at the given path.
using Convert = std::function<ImportReport(const std::string&)>;

/// Adds the subcommand of a format, which sets `convert` when it is chosen.
using AddFormat = CLI::App* (*)(CLI::App& app, Convert& convert);

CLI::App* add_victoria_park(CLI::App& app, Convert& convert);
CLI::App* add_mrclam(CLI::App& app, Convert& convert);
CLI::App* add_kitti(CLI::App& app, Convert& convert);
CLI::App* add_kitti_tracking(CLI::App& app, Convert& convert);
CLI::App* add_stata(CLI::App& app, Convert& convert);
CLI::App* add_plaza(CLI::App& app, Convert& convert);
CLI::App* add_carmen(CLI::App& app, Convert& convert);
CLI::App* add_clouds(CLI::App& app, Convert& convert);
CLI::App* add_detection_tables(CLI::App& app, Convert& convert);

inline constexpr std::array kFormats{add_victoria_park,  add_mrclam, add_kitti,
                                     add_kitti_tracking, add_stata,  add_plaza,
                                     add_carmen,         add_clouds, add_detection_tables};

}  // namespace hybrid
