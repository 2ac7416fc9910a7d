// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, the hybrid mapping authors

#include <functional>
#include <map>

#include "apps/exit_code.h"
#include "apps/hybrid-map/commands.h"
#include "apps/program.h"

int main(int argc, char** argv) {
  return hybrid::run_program("hybrid-map", [&] {
    int exit_code = hybrid::kExitOk;
    const auto options = hybrid::parse_options(argc, argv, exit_code);
    if (!options) return exit_code;
    const std::map<std::string, std::function<int(const hybrid::Options&)>> commands = {
        {"info", hybrid::info},
        {"check", hybrid::check},
        {"export", hybrid::export_map},
        {"join", hybrid::join},
        {"prune", hybrid::prune}};
    return commands.at(options->command)(*options);
  });
}
