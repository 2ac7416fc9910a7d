// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, the hybrid mapping authors
#include "libhybrid/selection/closure_posterior.h"

#include <gtest/gtest.h>

#include <cmath>

#include "libhybrid/baselines/gnc.h"
#include "libhybrid/factors/inflated.h"
#include "libhybrid/marginals/evidence.h"
#include "libhybrid/selection/closure_selection.h"
#include "libhybrid/solvers/levenberg_marquardt.h"
#include "tests/support/corrupted_graph.h"

namespace hybrid {
namespace {

using testing::CorruptedGraph;
using testing::pose;

/// Laps, with closures beside them that are some standard deviations off, more and more.
CorruptedGraph doubtful_laps(unsigned seed) {
  CorruptedGraph g = testing::drive_laps<SE2>(2, 3, seed);
  const Noise noise = Noise::isotropic(3, 0.01);
  for (int k = 0; k < 8; ++k) {
    const Key a = pose(k), b = pose(23 - k);
    const SE2 off(0.006 * k, -0.004 * k, 0.003 * k);
    g.problem.closures.push_back(std::make_shared<BetweenSE2>(
        a, b, g.poses.at<SE2>(a).between(g.poses.at<SE2>(b)) * off, noise));
    g.truth.push_back(k < 4);
  }
  return g;
}

/// log p of what is trusted, of the accepted closures but one, and of a factor for that one.
double evidence(const RobustProblem& problem, const std::vector<bool>& accepted, std::size_t but,
                const ContinuousFactorPtr& factor) {
  HybridGraph graph(problem.trusted);
  for (std::size_t k = 0; k < accepted.size(); ++k) {
    if (accepted[k] && k != but) graph.add(problem.closures[k]);
  }
  if (factor != nullptr) graph.add(factor);
  SolverOptions options;
  options.relative_decrease = 1e-12;
  const Values values = levenberg_marquardt(graph, {problem.initial, {}}, options).values;
  return *log_evidence(graph, {values, {}}).log;
}

TEST(ClosurePosterior, IsTheRatioOfTheEvidences) {
  int doubtful = 0, differs = 0;
  for (unsigned seed = 1; seed <= 3; ++seed) {
    const CorruptedGraph g = doubtful_laps(seed);
    for (const auto& [variance, flat] : {std::pair(30.0, false), {30.0, true}, {1e4, true}}) {
      MixtureOptions options;
      options.outlier_variance = variance;
      options.flat = flat;
      options.inlier_weight = 0.3;
      options.outlier_weight = 0.7;
      RobustResult result;
      result.values = g.problem.initial;
      result.decisions = make_decisions(g.problem, g.poses, g.truth, options);
      const std::vector<ClosureDecision> given = result.decisions;
      integrate_poses(g.problem, options, result);
      EXPECT_TRUE(result.poses_integrated);
      for (std::size_t k = 0; k < g.truth.size(); ++k) {
        const ContinuousFactorPtr& closure = g.problem.closures[k];
        const double in = evidence(g.problem, g.truth, k, closure) + std::log(0.3);
        double out = std::log(0.7);
        if (flat) {
          out += evidence(g.problem, g.truth, k, nullptr) - closure->log_normalizer() -
                 0.5 * 3 * std::log(variance);
        } else {
          out += evidence(g.problem, g.truth, k, std::make_shared<Inflated>(closure, variance));
        }
        const double expected = 1.0 / (1.0 + std::exp(out - in));
        EXPECT_NEAR(result.decisions[k].inlier_probability, expected, 0.01) << k;
        doubtful += expected > 0.02 && expected < 0.98;
        differs += std::abs(given[k].inlier_probability - expected) > 0.05;
      }
    }
  }
  EXPECT_GT(doubtful, 10);
  EXPECT_GT(differs, 10);
}

TEST(ClosurePosterior, LeavesReadmissionItsOwn) {
  const CorruptedGraph g = testing::drive_laps<SE2>(2, 3, 4);
  RobustResult result = select_closures(g.problem);
  const std::vector<ClosureDecision> before = result.decisions;
  integrate_poses(g.problem, {}, result);
  for (std::size_t k = 0; k < before.size(); ++k) {
    EXPECT_EQ(result.decisions[k].inlier_probability, before[k].inlier_probability);
  }
  result = solve_gnc(g.problem);
  EXPECT_FALSE(result.poses_integrated);
  integrate_poses(g.problem, {}, result);
  EXPECT_TRUE(result.poses_integrated);
}

TEST(ClosurePosterior, LeavesWhatIsUndeterminedAsItWas) {
  CorruptedGraph g = testing::drive_laps<SE2>(2, 0, 5);
  g.problem.trusted.erase(g.problem.trusted.begin());  // the prior
  RobustResult result;
  result.values = g.poses;
  result.decisions.resize(g.problem.closures.size());
  integrate_poses(g.problem, {}, result);
  EXPECT_FALSE(result.poses_integrated);
}

}  // namespace
}  // namespace hybrid
