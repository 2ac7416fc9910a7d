// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, the hybrid mapping authors

#include "mrpt_plugins/bridge/method_options.h"

namespace hybrid {
namespace {

constexpr IniRange kBetweenZeroAndOne{0.0, 1.0, true};
constexpr IniRange kLogOdds{0.0, 1e3};
constexpr IniRange kCount{1, 1000000};

MixtureOptions read_mixture(IniFile& ini, MixtureOptions o) {
  IniSection s = ini.section("mixture", "What a false closure looks like (eq. 17)");
  o.outlier_variance =
      s.get("outlier_variance", o.outlier_variance,
            "variance of a false closure in those of a true one", IniRange{1, 1e12});
  o.inlier_weight = s.get("inlier_weight", o.inlier_weight, "prior probability of a true closure",
                          kBetweenZeroAndOne);
  o.outlier_weight = 1.0 - o.inlier_weight;
  o.flat = s.get("flat", o.flat,
                 "false closures have a constant density, that of the peak of this Gaussian");
  const auto null = s.get("null_hypothesis", std::vector<double>{},
                          "instead of all that: -log density of a false closure, the same wherever "
                          "the poses are; empty: not used",
                          IniRange{-1e6, 1e6});
  if (null.size() > 1) s.fail("null_hypothesis", "takes one number");
  if (!null.empty()) o.null_hypothesis = null.front();
  return o;
}

void read_selection(IniFile& ini, ClosureSelectionOptions& o) {
  IniSection s = ini.section("selection", "Loop closure selection");
  o.margin =
      s.get("margin", o.margin,
            "a closure is admitted once the log of its evidence exceeds that of the number "
            "of closures that are out by this, and leaves once it falls short of it by as much",
            kLogOdds);
  o.degrees_of_freedom =
      s.get("degrees_of_freedom", o.degrees_of_freedom,
            "of the Student t of the innovations of true closures", IniRange{0.1, 1e6});
  o.gate = s.get("gate", o.gate,
                 "innovations beyond this multiple of the 0.9999 quantile of their chi-square are "
                 "refused, whatever the evidence",
                 IniRange{1e-3, 1e6});
  o.pairs = s.get("pairs", o.pairs,
                  "where no closure passes alone, admit the best two that agree with each other");
  o.trust_start =
      s.get("trust_start", o.trust_start,
            "start with the closures that agree with the initial values, not with none");
  s.replaces("min_redundancy", "min_redundancy", "online_selection");
  o.min_redundancy =
      s.get("min_redundancy", o.min_redundancy,
            "below it nothing else would reveal a false closure: it is flagged", kProbability);
  o.refuse_uncheckable =
      s.get("refuse_uncheckable", o.refuse_uncheckable, "refuse closures so flagged");
  o.max_rounds = s.get("max_rounds", o.max_rounds, "macro-steps tried", kCount);
  o.solver.relative_decrease = s.get("relative_decrease", o.solver.relative_decrease,
                                     "in batch: the last solve ends once an iteration promises to "
                                     "lower the cost by less than this "
                                     "share",
                                     IniRange{1e-15, 1e-2});
}

void read_online(IniFile& ini, OnlineSelectionOptions& o) {
  IniSection s =
      ini.section("online_selection",
                  "Loop closure selection pose by pose; all closures are evaluated again "
                  "with the settings of [selection]");
  o.decisive = s.get("decisive", o.decisive,
                     "a joint value of hypotheses of this much less log evidence than the best is "
                     "dropped",
                     IniRange{0.0, 1e3});
  o.patience =
      s.get("patience", o.patience,
            "closures kept back at which the best joint value of hypotheses is taken", kCount);
  o.spread =
      s.get("spread", o.spread,
            "evaluations of all closures, and tests of earlier ones, go on with each pose by "
            "so many times the work of a mean pose",
            IniRange{0.1, 1e9});
  o.smoother.relinearize = s.get("relinearize", o.smoother.relinearize,
                                 "as in [solver] of hybrid-replay", IniRange{1e-12, 1e6});
  o.smoother.wildfire = s.get("wildfire", o.smoother.wildfire, "as in [solver] of hybrid-replay",
                              IniRange{1e-15, 1e6});
  o.smoother.bend =
      s.get("bend", o.smoother.bend, "as in [solver] of hybrid-replay", IniRange{0.0, 1e6});
  o.smoother.bend_share = s.get("bend_share", o.smoother.bend_share,
                                "as in [solver] of hybrid-replay", IniRange{0.0, 1.0});
}

void read_baselines(IniFile& ini, MethodOptions& o) {
  IniSection alternation = ini.section("alternation", "The paper's alternation on eq. 16");
  o.alternation.alternating.max_iterations = alternation.get(
      "max_iterations", o.alternation.alternating.max_iterations, "pairs of half-steps", kCount);
  IniSection gnc = ini.section("gnc", "Graduated non-convexity");
  o.gnc.inlier_probability =
      gnc.get("inlier_probability", o.gnc.inlier_probability,
              "share of true closures below the threshold", kBetweenZeroAndOne);
  o.gnc.growth = gnc.get("growth", o.gnc.growth, "of mu, per round", IniRange{1.0, 1e6, true});
  o.gnc.max_rounds = gnc.get("max_rounds", o.gnc.max_rounds, "of weights and mu", kCount);
  o.gnc.iterations_per_round = gnc.get("iterations_per_round", o.gnc.iterations_per_round,
                                       "of the weighted least squares", IniRange{1, 1000});
  o.gnc.restart = gnc.get("restart", o.gnc.restart, "start every round at the initial values");
  o.dcs.phi =
      ini.section("dcs", "Dynamic covariance scaling")
          .get("phi", o.dcs.phi, "squared norm beyond which a closure is scaled down", kPositive);
  o.switchable.phi =
      ini.section("switchable", "Switchable constraints")
          .get("phi", o.switchable.phi, "inverse variance of the prior of a switch", kPositive);
  IniSection consistency = ini.section("consistency", "Pairwise consistency");
  o.consistency.probability =
      consistency.get("probability", o.consistency.probability,
                      "with which two true closures agree", kBetweenZeroAndOne);
  o.consistency.max_nodes =
      consistency.get("max_nodes", static_cast<int>(o.consistency.max_nodes),
                      "of the exact search; 0: greedy only", IniRange{0, 1e9});
  o.consistency.max_closures =
      consistency.get("max_closures", o.consistency.max_closures,
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
