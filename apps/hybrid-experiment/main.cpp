// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, the hybrid mapping authors

#include <fmt/format.h>

#include <cstdio>
#include <exception>
#include <filesystem>

#include "apps/exit_code.h"
#include "apps/hybrid-experiment/experiment.h"
#include "apps/hybrid-experiment/options.h"

int main(int argc, char** argv) try {
  int exit_code = hybrid::kExitOk;
  const auto options = hybrid::parse_options(argc, argv, exit_code);
  if (!options) return exit_code;
  if (options->print_config) {
    fmt::print("{}", hybrid::config_text(*options));
    return hybrid::kExitOk;
  }
  return hybrid::run_experiment(*options, std::filesystem::read_symlink("/proc/self/exe"));
} catch (const std::exception& e) {
  fmt::print(stderr, "hybrid-experiment: {}\n", e.what());
  return hybrid::kExitFailure;
}
