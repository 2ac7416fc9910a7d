// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, the hybrid mapping authors

#include <fmt/format.h>

#include <cstdio>
#include <exception>

#include "apps/exit_code.h"
#include "apps/hybrid-switching/options.h"
#include "apps/hybrid-switching/range_log.h"
#include "apps/hybrid-switching/reports.h"

int main(int argc, char** argv) try {
  int exit_code = hybrid::kExitOk;
  const auto options = hybrid::parse_options(argc, argv, exit_code);
  if (!options) return exit_code;
  if (hybrid::is_range_log(options->input)) {
    hybrid::report_ranges(*options);
  } else {
    hybrid::report_series(*options);
  }
  return hybrid::kExitOk;
} catch (const std::exception& e) {
  fmt::print(stderr, "hybrid-switching: {}\n", e.what());
  return hybrid::kExitFailure;
}
