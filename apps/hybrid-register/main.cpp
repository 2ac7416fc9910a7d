// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, the hybrid mapping authors

#include <fmt/format.h>

#include <cstdio>
#include <exception>

#include "apps/exit_code.h"
#include "apps/hybrid-register/options.h"
#include "apps/hybrid-register/run.h"

int main(int argc, char** argv) try {
  int exit_code = hybrid::kExitOk;
  const auto options = hybrid::parse_options(argc, argv, exit_code);
  return options ? hybrid::run(*options) : exit_code;
} catch (const std::exception& e) {
  fmt::print(stderr, "hybrid-register: {}\n", e.what());
  return hybrid::kExitFailure;
}
