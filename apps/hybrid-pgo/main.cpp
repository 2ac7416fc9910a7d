// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, the hybrid mapping authors

#include "apps/exit_code.h"
#include "apps/hybrid-pgo/optimize.h"
#include "apps/hybrid-pgo/options.h"
#include "apps/program.h"

int main(int argc, char** argv) {
  return hybrid::run_program("hybrid-pgo", [&] {
    int exit_code = hybrid::kExitOk;
    const auto options = hybrid::parse_options(argc, argv, exit_code);
    return options ? hybrid::optimize(*options) : exit_code;
  });
}
