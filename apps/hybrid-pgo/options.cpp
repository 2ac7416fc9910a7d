// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, the hybrid mapping authors

#include "apps/hybrid-pgo/options.h"

#include <fmt/format.h>

#include <filesystem>

#include "apps/command_line.h"
#include "apps/method_list.h"
#include "libhybrid/core/error.h"
#include "mrpt_plugins/bridge/method_options.h"

namespace hybrid {
namespace {

constexpr Interval kIterations{1, 1000000};
constexpr Interval kOperations{1, 1e14};

constexpr const char* kAbout =
    "Optimises a pose graph in g2o or TORO form, in the plane or in space, with landmarks or "
    "without.\n";

std::string footer() {
  return "\nMethods:\n" + method_list() +
         "\nWritten to OUT: graph.g2o (estimate and measurements), trajectory.tum (the id of a "
         "pose\n"
         "as its time), loops.csv, summary.json, graph_start.png, graph.png; with a truth\n"
         "trajectory_truth.tum; steps.csv with --online; hypotheses.csv for a graph with "
         "hypotheses;\n"
         "report.html with --report. They replace the result that\n"
         "OUT holds; files of others "
         "stay.\n"
         "\nExit code: 0 all well; 1 failure, nothing written; 2 the solver stopped at its limit "
         "of\n"
         "iterations: the estimate was written, and summary.json has status \"partial\"; 129, 130, "
         "143\n"
         "stopped by SIGHUP, SIGINT (Ctrl-C), SIGTERM: --online writes the graph so far, status\n"
         "\"interrupted\", and a second signal ends at once; a batch solver ends at once, with "
         "nothing\n"
         "written.\n"
         "\nExamples: hybrid-pgo intel.g2o --online -o out\n"
         "          hybrid-pgo bicocca.g2o --online --trusted odometry -o out\n"
         "          hybrid-pgo intel.g2o --method gnc --set gnc.growth=1.2 -o out";
}

/// Sets the default method if none is given, and the current name for a deprecated one.
void choose_method(Options& options) {
  if (options.method.empty() && !options.online) options.method = "selection";
  if (options.method.empty()) return;
  const std::string& name = robust_method(options.method).name;
  if (name != options.method) {
    options.warnings.push_back(fmt::format("--method {} is now called {}", options.method, name));
  }
  options.method = name;
  if (name == "oracle" && options.labels.empty()) throw Error("--method oracle needs --labels");
  if (name == "online") {
    options.online = true;
    if (options.trusted.empty()) options.trusted = "odometry";
  }
}

void read_methods(IniFile& ini, const std::vector<std::string>& settings, Options& options) {
  ini.override_values(settings);
  MethodOptions defaults;
  defaults.portfolio.selection.solver.relative_decrease = 1e-9;
  options.methods = read_method_options(ini, defaults);
  IniSection solver = ini.section("solver", "Levenberg-Marquardt, in batch");
  options.solver.max_iterations =
      solver.get("max_iterations", 1000, "linear systems that are solved at most", kIterations);
  options.solver.relative_decrease = solver.get(
      "relative_decrease", 1e-9,
      "lm ends once an iteration promises to lower the cost by less than this share; for selection "
      "see [selection]",
      {1e-15, 1e-2});
  options.solver.max_operations =
      solver.get("max_operations", 5e10,
                 "multiplications and additions of all factorisations of lm at most, some "
                 "20 s; maps of 10,000 poses need a fiftieth of it",
                 kOperations);
  options.methods.common.solver.max_iterations = options.solver.max_iterations;
  options.methods.portfolio.selection.solver.max_iterations = options.solver.max_iterations;
  ini.reject_unknown();
  options.provenance.configuration = ini.settings();
  options.warnings.insert(options.warnings.end(), ini.warnings().begin(), ini.warnings().end());
}

/// Options of the graph and its closures.
void add_graph_options(CLI::App& app, Options& options) {
  CLI::Option* method =
      app.add_option("--method", options.method,
                     "what becomes of loop closures that may be false, see below; default: "
                     "selection. lm trusts all; oracle needs --labels; online is --online "
                     "--trusted odometry")
          ->type_name("METHOD");
  app.add_option("--trusted", options.trusted,
                 "measurements that are not in question: all (default online), odometry (from "
                 "pose i to i + 1; default else), or a file of rows 'i j': online, of closures "
                 "beside odometry; else of all of them")
      ->type_name("all|odometry|FILE");
  app.add_option("--labels", options.labels,
                 "true loop closures, rows 'i j', or 'i j 0|1': for loop_precision and loop_recall")
      ->type_name("FILE");
  app.add_flag("--online", options.online,
               "incrementally, pose by pose, then to convergence; writes steps.csv")
      ->excludes(method);
  app.add_option(
         "--start", options.start,
         "start at the poses of the file, chain the odometry, solve linearly for rotations, "
         "then translations, or follow the shortest paths. auto (default): the file if it "
         "has a VERTEX line for every vertex, else the odometry, and with --method lm, "
         "where noise does not explain what that comes to, the best of all. Online, poses "
         "start at their first measurement, and this tells the first pose only")
      ->type_name("START")
      ->check(CLI::IsMember({"auto", "file", "odometry", "chordal", "tree"}));
  app.add_option("--shuffle", options.shuffle,
                 "seed of a random order of the hypotheses of an edge, which is that of the file "
                 "without it")
      ->type_name("SEED");
  app.add_option("--truth", options.truth,
                 "true poses: a graph file (by id), a TUM file (.tum), or rows 'x y angle' or "
                 "'x y z yaw pitch roll' (in order of the ids)")
      ->type_name("FILE");
  app.add_flag("--certify", options.certify,
               "verify that no other poses fit the odometry and the accepted closures better (dual "
               "certificate of SE-Sync, of the isotropic problem); in batch, where they do, solve "
               "again from poses of the Riemannian staircase, and bound the joint objective of "
               "all decisions about closures");
  app.add_flag("--repair-information", options.repair_information,
               "put the nearest positive definite matrix in the place of information that is not, "
               "and say of how many edges");
  app.add_flag("--report", options.report,
               "write report.html, a page to look into the graph and its closures with a browser");
  app.add_flag("!--no-pictures", options.pictures, "do not draw graph_start.png and graph.png");
  add_picture_format(app, options.picture_format);
  add_retired_flag(app, "--sparsity");
}

}  // namespace

bool trusts_all(const Options& options) {
  return options.method == "lm" || options.trusted == "all";
}

std::optional<Options> parse_options(int argc, char** argv, int& exit_code) {
  Options options;
  CLI::App app(kAbout, "hybrid-pgo");
  app.footer(footer());
  app.add_option("graph", options.graph, "the graph, .g2o or .graph")->type_name("GRAPH");
  add_graph_options(app, options);
  std::string config;
  std::vector<std::string> settings;
  bool print_config = false;
  app.add_option("-c,--config", config, "INI file with settings of the methods; see --print-config")
      ->type_name("INI");
  add_settings(app, settings);
  app.add_flag("--print-config", print_config,
               "print every section and key with its meaning, default and the value in effect");
  add_output_folder(app, options.output);
  app.callback([&] {
    if (options.graph.empty() && !print_config) throw CLI::RequiredError("GRAPH");
  });
  if (!parse_command_line(app, argc, argv, exit_code)) return std::nullopt;
  options.provenance = provenance_of(argc, argv);
  choose_method(options);
  IniFile ini = config.empty() ? IniFile() : IniFile(std::filesystem::path(config));
  read_methods(ini, settings, options);
  options.provenance.add_input(config);
  if (!print_config) return options;
  fmt::print("{}", ini.documentation());
  exit_code = kExitOk;
  return std::nullopt;
}

}  // namespace hybrid
