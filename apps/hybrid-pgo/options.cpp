// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, the hybrid mapping authors

#include "apps/hybrid-pgo/options.h"

#include "apps/command_line.h"

namespace hybrid {
namespace {

constexpr const char* kAbout =
    "Optimises a pose graph in g2o or TORO form, in the plane or in space, with landmarks or "
    "without.\n";

constexpr const char* kFooter =
    "\nWritten to OUT: graph.g2o (estimate and measurements), graph.png, loops.csv, summary.json;\n"
    "steps.csv with --online; hypotheses.csv for a graph with hypotheses;\n"
    "sparsity_*.png with --sparsity. They replace the result that OUT holds; files of others "
    "stay.\n"
    "\nExit code: 0 all well; 1 failure, nothing written; 2 the solver stopped at its limit of\n"
    "iterations: the estimate was written, and summary.json has status \"partial\"; 129, 130, 143\n"
    "stopped by SIGHUP, SIGINT (Ctrl-C), SIGTERM: --online writes the graph so far, status\n"
    "\"interrupted\", and a second signal ends at once; a batch solver ends at once, with nothing\n"
    "written.\n"
    "\nExamples: hybrid-pgo intel.g2o --online -o out\n"
    "          hybrid-pgo bicocca.g2o --online --trusted odometry -o out";

}  // namespace

std::optional<Options> parse_options(int argc, char** argv, int& exit_code) {
  Options options;
  CLI::App app(kAbout, "hybrid-pgo");
  app.footer(kFooter);
  app.add_option("graph", options.graph, "the graph, .g2o or .graph")
      ->type_name("GRAPH")
      ->required();
  CLI::Option* method =
      app.add_option("--method", options.method,
                     "what becomes of loop closures that may be false: escape (default) admits "
                     "them by predicted innovation; portfolio takes the best of several; "
                     "alternating, gnc, dcs, switchable, max-mixture for comparison; lm: "
                     "Levenberg-Marquardt that trusts all")
          ->type_name("METHOD")
          ->check(CLI::IsMember({"lm", "gnc", "dcs", "switchable", "max-mixture", "alternating",
                                 "escape", "portfolio"}));
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
  app.add_option("--start", options.start,
                 "start at the poses of the file, chain the odometry, or solve linearly for "
                 "rotations, then "
                 "translations; default: the file if it "
                 "has a VERTEX line for every vertex. Online, poses start at their first "
                 "measurement, and this tells the first pose only")
      ->type_name("file|odometry|chordal")
      ->check(CLI::IsMember({"file", "odometry", "chordal"}));
  app.add_option("--shuffle", options.shuffle,
                 "seed of a random order of the hypotheses of an edge, which is that of the file "
                 "without it")
      ->type_name("SEED");
  app.add_option("--truth", options.truth,
                 "true poses: a graph file (by id), a TUM file (.tum), or rows 'x y angle' or "
                 "'x y z yaw pitch roll' (in order of the ids)")
      ->type_name("FILE");
  app.add_flag("--sparsity", options.sparsity,
               "draw the structure of Jacobian, information matrix, its Cholesky factor with "
               "fill-in, and of a marginalisation");
  add_output_folder(app, options.output);
  if (!parse_command_line(app, argc, argv, exit_code)) return std::nullopt;
  options.provenance = provenance_of(argc, argv);
  if (options.method.empty() && !options.online) options.method = "escape";
  return options;
}

}  // namespace hybrid
