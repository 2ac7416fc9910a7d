// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, the hybrid mapping authors
#include "libhybrid/solvers/alternating.h"

#include <gtest/gtest.h>

#include "libhybrid/factors/between.h"
#include "libhybrid/solvers/levenberg_marquardt.h"
#include "tests/support/dense_system.h"
#include "tests/support/simulated_graphs.h"

namespace hybrid {
namespace {

/// The least joint objective over all assignments, each solved from the same start.
double exhaustive_objective(const testing::SimulatedGraph& s) {
  const std::vector<DiscreteKey> keys = s.graph.discrete_keys();
  double best = std::numeric_limits<double>::infinity();
  for (std::size_t code = 0; code < (std::size_t(1) << keys.size()); ++code) {
    Estimate start = s.initial;
    for (std::size_t i = 0; i < keys.size(); ++i) {
      start.assignment.set(keys[i].key, (code >> i) & 1);
    }
    const SolverResult solved = levenberg_marquardt(s.graph, start);
    best = std::min(best, objective(s.graph, solved.values, start.assignment));
  }
  return best;
}

TEST(Alternating, NeverRaisesTheObjectiveAndEndsAtAStationaryPoint) {
  int converged = 0;
  for (unsigned seed = 0; seed < 300; ++seed) {
    const auto s = testing::simulate_outliers(12, 8, 0.4, seed % 2 == 0, seed);
    AlternatingOptions options;
    options.continuous_iterations = seed % 3 == 0 ? 1 : 100;
    const AlternatingResult result = alternate(s.graph, s.initial, options);
    const AlternatingReport& report = result.report;
    EXPECT_NEAR(report.initial_objective,
                objective(s.graph, s.initial.values, s.initial.assignment), 1e-8);
    double before = report.initial_objective;
    for (const HalfStep& half : report.half_steps) {
      ASSERT_LE(half.objective, before) << "seed " << seed;
      before = half.objective;
    }
    EXPECT_EQ(report.objective, before);
    EXPECT_NEAR(report.objective,
                objective(s.graph, result.estimate.values, result.estimate.assignment),
                1e-8 * (1.0 + std::abs(report.objective)));
    // Outliers are left out of the couplings of H, so that its decrement is that of J'J but for
    // their share in it.
    if (report.status != SolverStatus::kConverged) continue;
    ++converged;
    const testing::DenseSystem at(s.graph, result.estimate);
    EXPECT_LE(at.promise(), 10.0 * options.continuous.relative_decrease * at.cost) << seed;
  }
  EXPECT_GT(converged, 280);
}

TEST(Alternating, EndsWhereTheDiscreteStepIsExact) {
  for (unsigned seed = 0; seed < 50; ++seed) {
    const auto s = testing::simulate_outliers(10, 6, 0.4, true, seed);
    const AlternatingResult result = alternate(s.graph, s.initial);
    const std::vector<DiscreteKey> keys = s.graph.discrete_keys();
    for (std::size_t code = 0; code < (std::size_t(1) << keys.size()); ++code) {
      Assignment other;
      for (std::size_t i = 0; i < keys.size(); ++i) other.set(keys[i].key, (code >> i) & 1);
      EXPECT_GE(objective(s.graph, result.estimate.values, other),
                result.report.objective - 1e-7 * std::abs(result.report.objective));
    }
  }
}

TEST(Alternating, MeetsTheExhaustiveOptimumOnMostEasyGraphsAndNeverBeatsIt) {
  int met = 0;
  for (unsigned seed = 0; seed < 20; ++seed) {
    const auto s = testing::simulate_outliers(5, 6, 0.3, false, seed);
    const double best = exhaustive_objective(s);
    const double ours = alternate(s.graph, s.initial).report.objective;
    EXPECT_GE(ours, best - 1e-4);
    if (ours < best + 1e-3) ++met;
  }
  EXPECT_GE(met, 15);
}

TEST(Alternating, KeepsTheIncumbentOfATie) {
  HybridGraph graph;
  Estimate initial;
  initial.values.insert(Key('p', 0), Eigen::Vector2d(0.0, 0.0));
  const Noise noise = Noise::isotropic(2, 1.0);
  std::vector<MixtureComponent> twins;
  for (int i = 0; i < 2; ++i) {
    twins.push_back(
        {std::make_shared<Prior<Eigen::Vector2d>>(Key('p', 0), Eigen::Vector2d(1.0, 1.0), noise),
         0.0, false});
  }
  graph.add(HybridFactorPtr(
      std::make_shared<Mixture>(std::vector<DiscreteKey>{{Key('d', 0), 2}}, twins)));
  for (int value = 0; value < 2; ++value) {
    initial.assignment.set(Key('d', 0), value);
    EXPECT_EQ(alternate(graph, initial).estimate.assignment.at(Key('d', 0)), value);
  }
}

TEST(Alternating, KeepsTheAnalysisWhenComponentsTouchTheSameVariables) {
  auto s = testing::simulate_loops<SE2, BetweenSE2>(20, 10, 0.05, 1);
  for (int k = 0; k < 5; ++k) {
    std::vector<MixtureComponent> components;
    for (double offset : {0.0, 3.0}) {
      components.push_back(
          {std::make_shared<BetweenSE2>(testing::pose(k), testing::pose(k + 10),
                                        SE2(offset, 0.0, 0.0), Noise::isotropic(3, 0.5)),
           0.0, false});
    }
    s.graph.add(HybridFactorPtr(
        std::make_shared<Mixture>(std::vector<DiscreteKey>{{Key('d', k), 2}}, components)));
    s.initial.assignment.set(Key('d', k), k % 2);
  }
  const AlternatingResult result = alternate(s.graph, s.initial);
  int flips = 0;
  for (const HalfStep& half : result.report.half_steps) flips += half.discrete ? half.changes : 0;
  EXPECT_GT(flips, 0);
  EXPECT_EQ(result.report.analyses, 1);
}

TEST(Alternating, AVariableOfAnotherTypeIsNamedWithItsFactor) {
  HybridGraph graph;
  const Key x('x', 0), y('x', 1);
  graph.emplace<BetweenSE2>(x, y, SE2(), Noise::unit(3));
  Estimate initial;
  initial.values.insert(x, SE2());
  initial.values.insert(y, SE3());
  try {
    alternate(graph, initial);
    ADD_FAILURE();
  } catch (const Error& error) {
    EXPECT_STREQ(error.what(), "variable x1 is SE3, but a factor on x0 x1 takes it as SE2");
  }
}

TEST(Alternating, SaysWhereNothingIsPossible) {
  const DiscreteKey d{Key('d', 0), 2};
  const Table never({d}, {INFINITY, INFINITY});
  const Table first({d}, {0.0, INFINITY}), second({d}, {INFINITY, 0.0}), huge({d}, {1e308, 1e308});
  for (const auto& tables : {std::vector<Table>{never}, {first, second}, {huge, huge}}) {
    auto s = testing::simulate_loops<SE2, BetweenSE2>(5, 2, 0.05, 1);
    for (const Table& table : tables) s.graph.add(table);
    for (const int value : {0, 1}) {
      s.initial.assignment.set(d.key, value);
      const AlternatingReport report = alternate(s.graph, s.initial).report;
      EXPECT_EQ(report.status, AlternatingStatus::kNotFinite);
      EXPECT_EQ(report.message, "no joint value of d0 is possible: every one has infinite cost");
    }
  }
}

TEST(Alternating, StopsAtTheIterationLimit) {
  const auto s = testing::simulate_outliers(12, 8, 0.4, false, 3);
  AlternatingOptions options;
  options.max_iterations = 1;
  options.continuous_iterations = 1;
  const AlternatingResult result = alternate(s.graph, s.initial, options);
  EXPECT_EQ(result.report.status, AlternatingStatus::kIterationLimit);
  EXPECT_EQ(result.report.half_steps.size(), 2u);
}

}  // namespace
}  // namespace hybrid
