// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, the hybrid mapping authors

#include "mrpt_plugins/bridge/method_options.h"

namespace hybrid {
namespace {

constexpr Interval kBetweenZeroAndOne{0.0, 1.0, true};
constexpr Interval kLogOdds{0.0, 1e3};
constexpr Interval kCount{1, 1000000};

MixtureOptions read_mixture(IniFile& ini, MixtureOptions o) {
  IniSection s = ini.section("mixture", "What a false closure looks like (eq. 17)");
  s.read("outlier_variance", o.outlier_variance,
         "variance of a false closure in those of a true one", {1, 1e12});
  s.read("inlier_weight", o.inlier_weight, "prior probability of a true closure",
         kBetweenZeroAndOne);
  o.outlier_weight = 1.0 - o.inlier_weight;
  s.read("flat", o.flat,
         "false closures have a constant density, that of the peak of this Gaussian");
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
  s.read("margin", o.margin,
         "a closure is admitted once the log of its evidence exceeds that of the number of "
         "closures that are out by this, and leaves once it falls short of it by as much",
         kLogOdds);
  s.read("degrees_of_freedom", o.degrees_of_freedom,
         "of the Student t of the innovations of true closures", {0.1, 1e6});
  s.read("gate", o.gate,
         "innovations beyond this multiple of the 0.9999 quantile of their chi-square are refused, "
         "whatever the evidence",
         {1e-3, 1e6});
  s.read("pairs", o.pairs,
         "where no closure passes alone, admit the best two that agree with each other");
  s.read("trust_start", o.trust_start,
         "start with the closures that agree with the initial values, not with none");
  s.replaces("min_redundancy", "min_redundancy", "online_selection");
  s.read("min_redundancy", o.min_redundancy,
         "below it nothing else would reveal a false closure: it is flagged", kProbability);
  s.read("refuse_uncheckable", o.refuse_uncheckable, "refuse closures so flagged");
  s.read("max_rounds", o.max_rounds, "macro-steps tried", kCount);
  s.read("relative_decrease", o.solver.relative_decrease,
         "in batch: the last solve ends once an iteration promises to lower the cost by less than "
         "this share",
         {1e-15, 1e-2});
}

void read_online(IniFile& ini, OnlineSelectionOptions& o) {
  IniSection s =
      ini.section("online_selection",
                  "Loop closure selection pose by pose; all closures are evaluated again "
                  "with the settings of [selection]");
  s.read("decisive", o.decisive,
         "a joint value of hypotheses of this much less log evidence than the best is dropped",
         {0.0, 1e3});
  s.read("patience", o.patience,
         "closures kept back at which the best joint value of hypotheses is taken", kCount);
  s.read("spread", o.spread,
         "evaluations of all closures, and tests of earlier ones, go on with each pose by so many "
         "times the work of a mean pose",
         {0.1, 1e9});
  s.read("relinearize", o.smoother.relinearize, "as in [solver] of hybrid-replay", {1e-12, 1e6});
  s.read("wildfire", o.smoother.wildfire, "as in [solver] of hybrid-replay", {1e-15, 1e6});
  s.read("bend", o.smoother.bend, "as in [solver] of hybrid-replay", {0.0, 1e6});
  s.read("bend_share", o.smoother.bend_share, "as in [solver] of hybrid-replay", {0.0, 1.0});
}

void read_baselines(IniFile& ini, MethodOptions& o) {
  IniSection alternation = ini.section("alternation", "The paper's alternation on eq. 16");
  alternation.read("max_iterations", o.alternation.alternating.max_iterations,
                   "pairs of half-steps", kCount);
  IniSection gnc = ini.section("gnc", "Graduated non-convexity");
  gnc.read("inlier_probability", o.gnc.inlier_probability,
           "share of true closures below the threshold", kBetweenZeroAndOne);
  gnc.read("growth", o.gnc.growth, "of mu, per round", {1.0, 1e6, true});
  gnc.read("max_rounds", o.gnc.max_rounds, "of weights and mu", kCount);
  gnc.read("iterations_per_round", o.gnc.iterations_per_round, "of the weighted least squares",
           {1, 1000});
  gnc.read("restart", o.gnc.restart, "start every round at the initial values");
  o.dcs.phi =
      ini.section("dcs", "Dynamic covariance scaling")
          .get("phi", o.dcs.phi, "squared norm beyond which a closure is scaled down", kPositive);
  o.switchable.phi =
      ini.section("switchable", "Switchable constraints")
          .get("phi", o.switchable.phi, "inverse variance of the prior of a switch", kPositive);
  IniSection consistency = ini.section("consistency", "Pairwise consistency");
  consistency.read("probability", o.consistency.probability, "with which two true closures agree",
                   kBetweenZeroAndOne);
  o.consistency.max_nodes = consistency.get("max_nodes", static_cast<int>(o.consistency.max_nodes),
                                            "of the exact search; 0: greedy only", {0, 1e9});
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
  options.portfolio.gnc = ini.section("portfolio", "Several methods and starts")
                              .get("gnc", options.portfolio.gnc, "gnc, the slowest, is a member");
  read_baselines(ini, options);
  return options;
}

}  // namespace hybrid
