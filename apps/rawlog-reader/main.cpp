// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, the hybrid mapping authors

#include <string>
#include <vector>

#include "mrpt_plugins/rawlog/parser_main.h"

/// Started by the library alone, where it cannot fork: parses a rawlog that is open already.
int main(int argc, char** argv) {
  return hybrid::run_rawlog_reader(std::vector<std::string>(argv, argv + argc));
}
