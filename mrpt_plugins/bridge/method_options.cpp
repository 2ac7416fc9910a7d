// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, the hybrid mapping authors

#include "mrpt_plugins/bridge/method_options.h"

#include "mrpt_plugins/bridge/read_options.h"

namespace hybrid {
namespace {

constexpr Interval kBetweenZeroAndOne{0.0, 1.0, true};
constexpr Interval kCount{1, 1000000};

MixtureOptions read_mixture(IniFile& ini, MixtureOptions o) {
  IniSection s = ini.section("mixture", "What a false closure looks like (eq. 17)");
  read_options(s, o);
  o.outlier_weight = 1.0 - o.inlier_weight;
  const auto null = s.get("null_hypothesis", std::vector<double>{},
                          "instead of all that: -log density of a false closure, the same wherever "
                          "the poses are; empty: not used",
                          {-1e6, 1e6});
  if (null.size() > 1) s.fail("null_hypothesis", "takes one number");
  if (!null.empty()) o.null_hypothesis = null.front();
  return o;
}

void read_selection(IniFile& ini, ClosureSelectionOptions& o) {
  IniSection s = ini.section("selection", "Loop closure selection");
  s.replaces("min_redundancy", "min_redundancy", "online_selection");
  read_options(s, o);
  read_option(s, o.solver, "relative_decrease", "in batch, of the last solve: ");
}

void read_online(IniFile& ini, OnlineSelectionOptions& o) {
  IniSection s =
      ini.section("online_selection",
                  "Loop closure selection pose by pose; all closures are evaluated again "
                  "with the settings of [selection]");
  read_options(s, o);
  for (const char* name : {"relinearize", "wildfire", "bend", "bend_share"}) {
    read_option(s, o.smoother, name);
  }
}

void read_baselines(IniFile& ini, MethodOptions& o) {
  read_option(ini.section("alternation", "The paper's alternation on eq. 16"),
              o.alternation.alternating, "max_iterations");
  IniSection gnc = ini.section("gnc", "Graduated non-convexity");
  gnc.read("inlier_probability", o.gnc.inlier_probability,
           "share of true closures below the threshold", kBetweenZeroAndOne);
  gnc.read("growth", o.gnc.growth, "of mu, per round", {1.0, 1e6, true});
  gnc.read("max_rounds", o.gnc.max_rounds, "of weights and mu", kCount);
  gnc.read("iterations_per_round", o.gnc.iterations_per_round, "of the weighted least squares",
           {1, 1000});
  gnc.read("restart", o.gnc.restart, "start every round at the initial values");
  ini.section("dcs", "Dynamic covariance scaling")
      .read("phi", o.dcs.phi, "squared norm beyond which a closure is scaled down", kPositive);
  ini.section("switchable", "Switchable constraints")
      .read("phi", o.switchable.phi, "inverse variance of the prior of a switch", kPositive);
  IniSection consistency = ini.section("consistency", "Pairwise consistency");
  consistency.read("probability", o.consistency.probability, "with which two true closures agree",
                   kBetweenZeroAndOne);
  consistency.read("max_nodes", o.consistency.max_nodes, "of the exact search; 0: greedy only",
                   {0, 1e9});
  consistency.read("max_closures", o.consistency.max_closures,
                   "more are refused: time and memory grow with their square", kCount);
}

}  // namespace

MethodOptions read_method_options(IniFile& ini, const MethodOptions& defaults) {
  MethodOptions options = defaults;
  options.set_mixture(read_mixture(ini, options.common.mixture));
  read_selection(ini, options.portfolio.selection);
  // Only the smoother converges the online solution: it needs no precise last solve.
  const SolverOptions online_solver = options.online.selection.solver;
  options.online.selection = options.portfolio.selection;
  options.online.selection.solver = online_solver;
  read_online(ini, options.online);
  ini.section("portfolio", "Several methods and starts")
      .read("gnc", options.portfolio.gnc, "gnc, the slowest, is a member");
  read_baselines(ini, options);
  return options;
}

}  // namespace hybrid
