// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, the hybrid mapping authors

#include "apps/exit_code.h"
#include "apps/hybrid-switching/options.h"
#include "apps/hybrid-switching/range_log.h"
#include "apps/hybrid-switching/reports.h"
#include "apps/program.h"

int main(int argc, char** argv) {
  return hybrid::run_program("hybrid-switching", [&] {
    int exit_code = hybrid::kExitOk;
    const auto options = hybrid::parse_options(argc, argv, exit_code);
    if (!options) return exit_code;
    return hybrid::is_range_log(options->input) ? hybrid::report_ranges(*options)
                                                : hybrid::report_series(*options);
  });
}
