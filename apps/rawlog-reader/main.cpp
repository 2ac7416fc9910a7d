// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, the hybrid mapping authors

#include <string>
#include <vector>

#include "mrpt_plugins/rawlog/parser_main.h"

/// Parses an open rawlog. Started only by the library, where it cannot fork.
int main(int argc, char** argv) {
  return hybrid::run_rawlog_reader(std::vector<std::string>(argv, argv + argc));
}
