// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, the hybrid mapping authors

#include <fmt/format.h>

#include "apps/exit_code.h"
#include "apps/hybrid-replay/options.h"
#include "apps/hybrid-replay/run.h"
#include "apps/program.h"
#include "mrpt_plugins/mapping/plugin_library.h"
#include "mrpt_plugins/settings/replay_settings.h"

int main(int argc, char** argv) {
  return hybrid::run_program("hybrid-replay", [&] {
    int exit_code = hybrid::kExitOk;
    const auto options = hybrid::parse_options(argc, argv, exit_code);
    if (!options) return exit_code;
    for (const std::string& path : options->request.plugin_libraries)
      hybrid::load_plugin_library(path);
    if (!options->print_config) return hybrid::run(options->request, options->strict);
    fmt::print("{}", hybrid::config_text(options->request));
    return static_cast<int>(hybrid::kExitOk);
  });
}
