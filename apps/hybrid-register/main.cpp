// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, the hybrid mapping authors

#include "apps/exit_code.h"
#include "apps/hybrid-register/options.h"
#include "apps/hybrid-register/run.h"
#include "apps/program.h"

int main(int argc, char** argv) {
  return hybrid::run_program("hybrid-register", [&] {
    int exit_code = hybrid::kExitOk;
    const auto options = hybrid::parse_options(argc, argv, exit_code);
    return options ? hybrid::run(*options) : exit_code;
  });
}
