// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, the hybrid mapping authors

#include <fmt/format.h>

#include <cstdio>
#include <exception>

#include "apps/exit_code.h"
#include "apps/hybrid-replay/options.h"
#include "apps/hybrid-replay/plugin_libraries.h"
#include "apps/hybrid-replay/replay.h"
#include "apps/hybrid-replay/settings.h"

int main(int argc, char** argv) try {
  int exit_code = hybrid::kExitOk;
  const auto options = hybrid::parse_options(argc, argv, exit_code);
  if (!options) return exit_code;
  hybrid::load_plugin_libraries(options->plugin_libraries);
  if (!options->print_config) return hybrid::replay(*options);
  fmt::print("{}", hybrid::config_text(*options));
  return hybrid::kExitOk;
} catch (const std::exception& e) {
  fmt::print(stderr, "hybrid-replay: {}\n", e.what());
  return hybrid::kExitFailure;
}
