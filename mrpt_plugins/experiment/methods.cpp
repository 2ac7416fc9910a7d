// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, the hybrid mapping authors

#include "mrpt_plugins/experiment/methods.h"

#include "libhybrid/baselines/least_squares.h"
#include "libhybrid/baselines/max_mixture.h"
#include "libhybrid/baselines/soft_mixture.h"
#include "libhybrid/core/error.h"

namespace hybrid {
const std::vector<MethodName>& method_names() {
  static const std::vector<MethodName> kNames = {
      {"odometry", "no closure is believed"},
      {"oracle", "Levenberg-Marquardt with the true closures only"},
      {"lm", "Levenberg-Marquardt with all closures"},
      {"gnc", "graduated non-convexity, truncated least squares"},
      {"gnc-gm", "graduated non-convexity, Geman-McClure"},
      {"dcs", "dynamic covariance scaling"},
      {"switchable", "switchable constraints"},
      {"max-mixture", "max-mixtures"},
      {"sum-mixture", "sum-mixtures"},
      {"alternating", "the paper's alternation on eq. 16"},
      {"escape", "re-admission of closures by their predicted innovations"},
      {"online", "pose by pose, closures judged as they arrive"},
      {"portfolio", "several of these and of starts, the lowest joint objective"},
      {"consistency", "pairwise consistency, then lm"},
      {"consistency-gnc", "pairwise consistency, then gnc"},
      {"consistency-escape", "pairwise consistency, then escape"}};
  return kNames;
}

MethodOptions read_method_options(IniFile& ini) {
  MethodOptions options;
  IniSection mixture = ini.section("mixture", "What a false closure looks like (eq. 17)");
  options.mixture.outlier_variance =
      mixture.get("outlier_variance", options.mixture.outlier_variance,
                  "variance of a false closure in those of a true one", IniRange{1, 1e12});
  options.mixture.inlier_weight =
      mixture.get("inlier_weight", options.mixture.inlier_weight,
                  "prior probability of a true closure", IniRange{0.0, 1.0, true});
  options.mixture.outlier_weight = 1.0 - options.mixture.inlier_weight;
  IniSection gnc = ini.section("gnc", "Graduated non-convexity");
  options.gnc.inlier_probability =
      gnc.get("inlier_probability", options.gnc.inlier_probability,
              "share of true closures below the threshold", IniRange{0.0, 1.0, true});
  options.gnc.growth =
      gnc.get("growth", options.gnc.growth, "of mu, per round", IniRange{1.0, 1e6, true});
  options.gnc.iterations_per_round =
      gnc.get("iterations_per_round", options.gnc.iterations_per_round,
              "of the weighted least squares", IniRange{1, 1000});
  options.gnc.restart =
      gnc.get("restart", options.gnc.restart, "start every round at the initial values");
  options.dcs.phi =
      ini.section("dcs", "Dynamic covariance scaling")
          .get("phi", options.dcs.phi, "squared norm that is still believed", kPositive);
  options.switchable.phi = ini.section("switchable", "Switchable constraints")
                               .get("phi", options.switchable.phi,
                                    "inverse variance of the prior of a switch", kPositive);
  IniSection consistency = ini.section("consistency", "Pairwise consistency");
  options.consistency.probability =
      consistency.get("probability", options.consistency.probability,
                      "with which two true closures agree", IniRange{0.0, 1.0, true});
  options.consistency.max_nodes =
      consistency.get("max_nodes", int(options.consistency.max_nodes),
                      "of the exact search; 0: greedy only", IniRange{0, 1e9});
  for (ComparisonOptions* each : {static_cast<ComparisonOptions*>(&options.gnc),
                                  static_cast<ComparisonOptions*>(&options.dcs),
                                  static_cast<ComparisonOptions*>(&options.switchable)}) {
    each->mixture = options.mixture;
    each->solver.threads = 1;
  }
  options.alternation.mixture = options.mixture;
  options.alternation.alternating.continuous.threads = 1;
  options.portfolio.escape.mixture = options.mixture;
  options.portfolio.escape.solver.threads = 1;
  options.online.mixture = options.mixture;
  options.online.mixture.flat = true;
  options.online.escape = options.portfolio.escape;
  return options;
}

RobustResult solve_by_name(const std::string& name, const RobustProblem& problem,
                           const std::vector<bool>& truth, const MethodOptions& options) {
  ComparisonOptions plain;
  plain.mixture = options.mixture;
  plain.solver.threads = 1;
  GncOptions gnc = options.gnc;
  const auto filtered = [&](const RobustSolver& solver) {
    return solve_consistent(problem, options.consistency, options.mixture, solver);
  };
  if (name == "odometry") {
    return solve_given(problem, std::vector<bool>(problem.closures.size(), false), plain);
  }
  if (name == "oracle") return solve_given(problem, truth, plain);
  if (name == "lm") return solve_lm(problem, plain);
  if (name == "gnc-gm") gnc.loss = GncLoss::kGemanMcClure;
  if (name == "gnc" || name == "gnc-gm") return solve_gnc(problem, gnc);
  if (name == "dcs") return solve_dcs(problem, options.dcs);
  if (name == "switchable") return solve_switchable(problem, options.switchable);
  if (name == "max-mixture") return solve_max_mixture(problem, plain);
  if (name == "sum-mixture") return solve_soft_mixture(problem, plain);
  if (name == "alternating") return solve_alternating(problem, options.alternation);
  if (name == "escape") return select_closures(problem, options.portfolio.escape);
  if (name == "portfolio") return solve_portfolio(problem, options.portfolio).best;
  if (name == "consistency-escape") {
    return filtered(
        [&](const RobustProblem& p) { return select_closures(p, options.portfolio.escape); });
  }
  if (name == "consistency") {
    return filtered([&](const RobustProblem& p) { return solve_lm(p, plain); });
  }
  if (name == "consistency-gnc") {
    return filtered([&](const RobustProblem& p) { return solve_gnc(p, gnc); });
  }
  throw Error("there is no method '" + name + "'");
}

}  // namespace hybrid
