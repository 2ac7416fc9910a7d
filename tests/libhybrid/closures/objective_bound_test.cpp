// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, the hybrid mapping authors
#include "libhybrid/closures/objective_bound.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <limits>

#include "libhybrid/factors/between.h"
#include "libhybrid/factors/prior.h"
#include "libhybrid/pose_graph/false_closures.h"
#include "libhybrid/solvers/levenberg_marquardt.h"
#include "tests/support/pose_graph_worlds.h"

namespace hybrid {
namespace {

struct Best {
  Values values;
  std::vector<bool> accepted;
  double objective = std::numeric_limits<double>::infinity();
};

/// The lowest objective over all decisions, each solved from several poses.
Best enumerate(const RobustProblem& problem, const std::vector<Values>& starts,
               const MixtureOptions& mixture) {
  Best best;
  const std::size_t count = problem.closures.size();
  for (std::size_t bits = 0; bits < (std::size_t{1} << count); ++bits) {
    std::vector<bool> accepted(count);
    for (std::size_t k = 0; k < count; ++k) accepted[k] = (bits >> k & 1) != 0;
    const HybridGraph graph(factors_in_force(problem, accepted));
    for (const Values& start : starts) {
      SolverOptions options;
      options.threads = 1;
      const Values values = levenberg_marquardt(graph, {start, {}}, options).values;
      const double objective = joint_objective(problem, values, accepted, mixture).objective;
      if (objective < best.objective) best = {values, accepted, objective};
    }
  }
  return best;
}

/// A small world with false closures, and at most seven closures in all.
RobustProblem make(unsigned seed, std::vector<Values>& starts) {
  worlds::World world = seed % 2 == 0
                            ? worlds::town(12, 1, 0.3, {0.05, 0.03 + 0.02 * (seed % 5)}, seed)
                            : worlds::torus(2, 5, {0.05, 0.03 + 0.02 * (seed % 5)}, seed);
  auto& planar = world.graph.poses2;
  if (planar.size() > 15) planar.erase(planar.begin() + 15, planar.end());
  const PoseGraph graph = add_false_closures(world.graph, 0.4, seed);
  starts = {world.truth, initialize_from_odometry(graph)};
  RobustProblem problem = to_robust_problem(graph, starts[1]);
  if (problem.closures.size() > 7) problem.closures.resize(7);
  return problem;
}

TEST(ObjectiveBound, IsNeverAboveTheEnumeratedOptimum) {
  double largest_gap = 0.0;
  int closures = 0;
  for (unsigned seed = 0; seed < 30; ++seed) {
    std::vector<Values> starts;
    const RobustProblem problem = make(seed, starts);
    closures += static_cast<int>(problem.closures.size());
    MixtureOptions mixture;
    mixture.flat = seed % 3 == 0;
    mixture.inlier_weight = seed % 4 == 0 ? 0.9 : 0.3;
    mixture.outlier_weight = 1.0 - mixture.inlier_weight;
    if (seed % 5 == 0) mixture.null_hypothesis = -3.0;
    const Best best = enumerate(problem, starts, mixture);
    double before = -std::numeric_limits<double>::infinity();
    for (const int budget : {0, 1, 8, 1000}) {
      const ObjectiveBound bound =
          bound_objective(problem, best.values, best.accepted, mixture, budget);
      EXPECT_LE(bound.bound, best.objective + 1e-6) << "seed " << seed;
      EXPECT_GE(bound.bound, before - 1e-6) << "a larger budget, a lower bound: seed " << seed;
      EXPECT_NEAR(bound.gap, best.objective - bound.bound, 1e-6);
      EXPECT_LE(bound.solves, budget);
      before = bound.bound;
      if (budget < 1000) continue;
      EXPECT_TRUE(bound.complete);
      largest_gap = std::max(largest_gap, bound.gap);
    }
    // The bound does not depend on the estimate but for its search.
    const std::vector<bool> none(problem.closures.size(), false);
    const ObjectiveBound other = bound_objective(problem, starts[1], none, mixture, 1000);
    EXPECT_LE(other.bound, best.objective + 1e-6) << "seed " << seed;
  }
  EXPECT_GT(closures, 60);
  // The slack of lower weights and of rotations compared as matrices.
  EXPECT_LT(largest_gap, 0.5);
}

TEST(ObjectiveBound, HoldsWithNoiseThatIsNotIsotropic) {
  for (unsigned seed = 1; seed <= 10; ++seed) {
    std::vector<Values> starts;
    RobustProblem problem = make(2 * seed + 1, starts);
    for (auto* factors : {&problem.trusted, &problem.closures}) {
      for (ContinuousFactorPtr& factor : *factors) {
        const auto motion = relative_pose<SE3>(*factor);
        if (!motion) continue;
        Eigen::Matrix<double, 6, 1> scale;
        scale << 1.0, 3.0, 0.3, 2.0, 0.5, 1.0;
        const SE3::Jacobian information =
            scale.asDiagonal() * motion->information * scale.asDiagonal();
        factor = std::make_shared<Between<SE3>>(factor->keys()[0], factor->keys()[1],
                                                motion->measured, Noise::information(information));
      }
    }
    const Best best = enumerate(problem, starts, {});
    const ObjectiveBound bound = bound_objective(problem, best.values, best.accepted, {}, 500);
    EXPECT_LE(bound.bound, best.objective + 1e-6) << "seed " << seed;
  }
}

TEST(ObjectiveBound, HoldsWithRobustLosses) {
  // Odometry of which a step disagrees with a trusted closure by 4 m, under a loss or not.
  for (const Loss& loss : {Loss(), Loss::huber(1.0), Loss::cauchy(1.0), Loss::tukey(4.0)}) {
    const Noise noise = Noise::isotropic(3, 0.1);
    RobustProblem problem;
    for (int i = 0; i < 5; ++i) problem.initial.insert(Key('x', i), SE2(i, 0, 0));
    problem.trusted.push_back(std::make_shared<Prior<SE2>>(Key('x', 0), SE2(), noise));
    const auto add = [&](int i, int j, double x, const Loss& loss) {
      problem.trusted.push_back(
          std::make_shared<Between<SE2>>(Key('x', i), Key('x', j), SE2(x, 0, 0), noise, loss));
    };
    for (int i = 1; i < 5; ++i) add(i - 1, i, 1.0, loss);
    add(0, 4, 8.0, loss);
    add(2, 3, 1.2, {});  // without a loss, in a part of its own
    problem.closures.push_back(
        std::make_shared<Between<SE2>>(Key('x', 1), Key('x', 3), SE2(2, 0, 0), noise));
    const Best best = enumerate(problem, {problem.initial}, {});
    const ObjectiveBound bound = bound_objective(problem, problem.initial, {true}, {}, 50);
    EXPECT_LE(bound.bound, best.objective + 1e-6);
    EXPECT_GT(bound.bound, -100.0);
  }
}

}  // namespace
}  // namespace hybrid
