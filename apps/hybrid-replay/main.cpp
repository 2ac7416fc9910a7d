// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, the hybrid mapping authors

#include <fmt/format.h>

#include "apps/exit_code.h"
#include "apps/hybrid-replay/options.h"
#include "apps/hybrid-replay/replay.h"
#include "apps/hybrid-replay/settings.h"
#include "apps/program.h"
#include "mrpt_plugins/mapping/plugin_library.h"

int main(int argc, char** argv) {
  return hybrid::run_program("hybrid-replay", [&] {
    int exit_code = hybrid::kExitOk;
    const auto options = hybrid::parse_options(argc, argv, exit_code);
    if (!options) return exit_code;
    for (const std::string& path : options->plugin_libraries) hybrid::load_plugin_library(path);
    if (!options->print_config) return hybrid::replay(*options);
    fmt::print("{}", hybrid::config_text(*options));
    return static_cast<int>(hybrid::kExitOk);
  });
}
