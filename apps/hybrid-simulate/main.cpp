// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, the hybrid mapping authors

#include <fmt/format.h>

#include <filesystem>
#include <memory>
#include <string>

#include "apps/command_line.h"
#include "apps/program.h"
#include "mrpt_plugins/simulation/simulator.h"

namespace {

constexpr const char* kAbout =
    "Simulates a robot among classed landmarks, things that move, and walls that a laser sees, "
    "with a receiver of satellites where asked: writes an MRPT rawlog and, beside it, what is "
    "true.";

constexpr const char* kFooter =
    "\nWritten together: F.rawlog, F_ground_truth.txt, F_ground_truth_robot_path.txt and, where "
    "the\n"
    "robot slips, F_ground_truth_modes.txt, where things move, F_ground_truth_movers.csv, with a\n"
    "receiver of satellites, F_ground_truth_fixes.csv; those of an older F.rawlog go.\n"
    "With sections [robot.NAME] in the INI, a log F_NAME.rawlog and its truth for each robot.\n"
    "\nExit code: 0 all well; 1 failure, nothing written.";

std::unique_ptr<hybrid::IniFile> open(const std::string& config, const std::string& seed) {
  auto ini = std::make_unique<hybrid::IniFile>(std::filesystem::path(config));
  if (!seed.empty()) ini->override_value("simulation", "seed", seed);
  return ini;
}

/// Writes a log; returns what there is to say of it.
std::string write(const hybrid::Scenario& scenario, const std::string& output) {
  const hybrid::Simulation simulation = hybrid::simulate(scenario);
  std::size_t detections = 0;
  for (const auto& frame : simulation.frames) detections += frame.detections.size();
  const auto files = hybrid::write_simulation(simulation, scenario, output);
  std::string text = fmt::format("{} frames, {} landmarks, {} detections", simulation.frames.size(),
                                 simulation.landmarks.size(), detections);
  if (scenario.fixes.period > 0) text += fmt::format(", {} fixes", simulation.fixes.size());
  text += '\n';
  for (const std::string& file : files) text += fmt::format("wrote {}\n", file);
  return text;
}

void run(const std::string& config, const std::string& output, const std::string& seed) {
  const auto file = open(config, seed);
  hybrid::IniFile& ini = *file;
  const hybrid::Scenario scenario = hybrid::read_scenario(ini);
  const auto robots = hybrid::read_robots(ini, [&] { return open(config, seed); });
  ini.reject_unknown();
  hybrid::warn_of(ini.warnings());
  std::string text;
  if (robots.empty()) text = write(scenario, output);
  for (const auto& [name, own] : robots) {
    const std::filesystem::path path = output;
    const std::string file = path.stem().string() + "_" + name + path.extension().string();
    text += write(own, (path.parent_path() / file).string());
  }
  hybrid::settle(hybrid::kExitOk);
  hybrid::say("{}", text);
}

void print_config(const std::string& config) {
  if (config.empty()) {
    hybrid::IniFile ini;
    hybrid::read_scenario(ini);
    fmt::print("{}", ini.documentation());
  } else {
    hybrid::IniFile ini{std::filesystem::path(config)};
    hybrid::read_scenario(ini);
    hybrid::read_robots(ini, [&] { return open(config, ""); });
    ini.reject_unknown();
    fmt::print("{}", ini.documentation());
  }
}

}  // namespace

int main(int argc, char** argv) {
  return hybrid::run_program("hybrid-simulate", [&] {
    CLI::App app(kAbout, "hybrid-simulate");
    app.footer(kFooter);
    std::string config, output, seed;
    bool print = false;
    app.add_option("-c,--config", config, "scenario, e.g. config/simulate_classed_demo.ini")
        ->type_name("INI");
    app.add_option("-o,--output", output, "the rawlog to write")->type_name("F.rawlog");
    app.add_option("--seed", seed, "instead of [simulation] seed")->type_name("NUMBER");
    app.add_flag("--print-config", print,
                 "Print all keys with meaning, default and value, and exit");
    app.callback([&] {
      if (!print && (config.empty() || output.empty())) {
        throw CLI::RequiredError("-c CONFIG with -o F.rawlog");
      }
    });
    int exit_code = hybrid::kExitOk;
    if (!hybrid::parse_command_line(app, argc, argv, exit_code)) return exit_code;
    if (print) {
      print_config(config);
    } else {
      run(config, output, seed);
    }
    return static_cast<int>(hybrid::kExitOk);
  });
}
