// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, the hybrid mapping authors

#include <fmt/format.h>

#include "apps/exit_code.h"
#include "apps/hybrid-experiment/experiment.h"
#include "apps/hybrid-experiment/join_ranks.h"
#include "apps/hybrid-experiment/options.h"
#include "apps/program.h"
#include "mrpt_plugins/bridge/interrupt.h"

int main(int argc, char** argv) {
  return hybrid::run_program("hybrid-experiment", [&] {
    int exit_code = hybrid::kExitOk;
    const auto options = hybrid::parse_options(argc, argv, exit_code);
    if (!options) return exit_code;
    if (options->print_config) {
      fmt::print("{}", hybrid::config_text(*options));
      return static_cast<int>(hybrid::kExitOk);
    }
    hybrid::note_interrupts();
    const std::unique_ptr<hybrid::Channel> ranks = hybrid::join_ranks();
    return ranks && ranks->rank() > 0 ? hybrid::serve_experiment(*options, *ranks)
                                      : hybrid::run_experiment(*options, ranks.get());
  });
}
