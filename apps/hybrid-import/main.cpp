// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, the hybrid mapping authors

#include <fmt/format.h>

#include <exception>

#include "apps/command_line.h"
#include "apps/hybrid-import/formats.h"

namespace {

void print(const hybrid::ImportReport& report) {
  fmt::print("{} steps over {:.1f} s, {} observations with {} detections, {} true landmarks\n",
             report.steps, report.duration, report.observations, report.detections,
             report.landmarks);
  for (const auto& [reason, count] : report.dropped) fmt::print("{}: {}\n", reason, count);
  for (const std::string& note : report.notes) fmt::print("{}\n", note);
  for (const std::string& file : report.files) fmt::print("wrote {}\n", file);
}

}  // namespace

int main(int argc, char** argv) try {
  CLI::App app(
      "Converts data sets of others into MRPT rawlogs, with what is true written beside them.",
      "hybrid-import");
  app.require_subcommand(1);
  std::string output;
  hybrid::Convert convert;
  for (const auto& add_format : hybrid::kFormats) {
    CLI::App* format = add_format(app, convert);
    format->add_option("-o,--output", output, "Rawlog to write, F.rawlog")->required();
  }
  int exit_code = hybrid::kExitOk;
  if (!hybrid::parse_command_line(app, argc, argv, exit_code)) return exit_code;
  print(convert(output));
  return hybrid::kExitOk;
} catch (const std::exception& e) {
  fmt::print(stderr, "hybrid-import: {}\n", e.what());
  return hybrid::kExitFailure;
}
