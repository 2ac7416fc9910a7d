// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, the hybrid mapping authors
#include "libhybrid/closures/mixture_graph.h"

#include <gtest/gtest.h>

#include <cmath>
#include <set>

#include "libhybrid/closures/objective_bound.h"
#include "libhybrid/core/error.h"
#include "libhybrid/factors/between.h"
#include "libhybrid/factors/expect_jacobians.h"
#include "libhybrid/factors/inflated.h"
#include "libhybrid/pose_graph/false_closures.h"
#include "tests/support/random.h"

namespace hybrid {
namespace {

/// A chain of n poses with closures from every pose to the third before it.
template <class Pose>
PoseGraph chain(int n) {
  testing::Random random(3);
  PoseGraph graph;
  std::vector<GraphEdge<Pose>> edges;
  const auto add = [&](int i, int j) {
    edges.push_back({Key('x', i), Key('x', j), random.value<Pose>(), random.noise(Pose::kDim)});
  };
  for (int i = 1; i < n; ++i) add(i - 1, i);
  for (int i = 3; i < n; ++i) add(i, i - 3);
  if constexpr (std::is_same_v<Pose, SE2>) {
    graph.poses2 = edges;
  } else {
    graph.poses3 = edges;
  }
  return graph;
}

TEST(Inflated, IsTheFactorWithAWiderNoise) {
  testing::Random random(7);
  const Noise noise = random.noise(3);
  const Key a('x', 0);
  const Key b('x', 1);
  const SE2 z = random.value<SE2>();
  Values values;
  values.insert(a, random.value<SE2>());
  values.insert(b, random.value<SE2>());
  const Inflated inflated(std::make_shared<BetweenSE2>(a, b, z, noise), 50.0);
  const BetweenSE2 wide(a, b, z, noise.inflated(50.0));
  EXPECT_NEAR(inflated.cost(values), wide.cost(values), 1e-12 * wide.cost(values));
  EXPECT_NEAR(inflated.log_normalizer(), wide.log_normalizer(), 1e-12);
  testing::expect_jacobians(inflated, values);
  EXPECT_THROW(Inflated(nullptr, 2.0), Error);
  EXPECT_THROW(Inflated(std::make_shared<BetweenSE2>(a, b, z, noise), 0.0), Error);
}

TEST(MixtureGraph, ObjectiveIsThatOfTheGraph) {
  const PoseGraph graph = chain<SE2>(12);
  const RobustProblem problem = to_robust_problem(graph, initialize_from_odometry(graph));
  EXPECT_EQ(problem.trusted.size(), 12u);  // odometry and the prior of the first pose
  ASSERT_EQ(problem.closures.size(), 9u);
  std::vector<bool> accepted(9, true);
  accepted[2] = accepted[5] = false;
  MixtureOptions constant;
  constant.null_hypothesis = 12.5;
  constant.inlier_weight = 0.8;
  constant.outlier_weight = 0.2;
  for (const MixtureOptions& options : {MixtureOptions(), constant}) {
    const HybridGraph hybrid = mixture_graph(problem, options);
    const JointObjective joint = joint_objective(problem, problem.initial, accepted, options);
    const Assignment assignment = to_assignment(accepted);
    const double expected = objective(hybrid, problem.initial, assignment);
    EXPECT_NEAR(joint.objective, expected, 1e-9 * std::abs(expected));
    double of_outliers = 0.0;
    if (!options.null_hypothesis) {
      for (int k : {2, 5}) of_outliers += problem.closures[k]->cost(problem.initial) / 1e7;
    }
    EXPECT_NEAR(joint.cost + of_outliers, cost(hybrid, problem.initial, assignment), 1e-6);
  }
  MixtureOptions wrong;
  wrong.outlier_weight = 0.0;
  EXPECT_THROW(mixture_graph(problem, wrong), Error);
}

TEST(MixtureGraph, NeedsADecisionOnEachClosure) {
  const PoseGraph graph = chain<SE2>(12);
  const RobustProblem problem = to_robust_problem(graph, initialize_from_odometry(graph));
  for (const std::size_t count : {10, 8, 0}) {
    const std::vector<bool> some(count, true);
    EXPECT_THROW(joint_objective(problem, problem.initial, some), Error) << count;
    EXPECT_THROW(make_decisions(problem, problem.initial, some), Error) << count;
    EXPECT_THROW(bound_objective(problem, problem.initial, some, {}, 1), Error) << count;
  }
}

TEST(MixtureGraph, RefusesOptionsThatAreNoModel) {
  const PoseGraph graph = chain<SE2>(12);
  const RobustProblem problem = to_robust_problem(graph, initialize_from_odometry(graph));
  const std::vector<bool> accepted(9, true);
  for (const double wrong : {std::nan(""), -1.0, 0.0, double(INFINITY)}) {
    std::vector<std::pair<std::string, MixtureOptions>> all(4);
    all[0].first = "outlier_variance";
    all[0].second.outlier_variance = wrong;
    all[1].first = "inlier_weight";
    all[1].second.inlier_weight = wrong;
    all[2].first = "outlier_weight";
    all[2].second.outlier_weight = wrong;
    all[3].first = "null_hypothesis";
    all[3].second.null_hypothesis = std::isfinite(wrong) ? -INFINITY : wrong;
    for (const auto& [name, options] : all) {
      try {
        joint_objective(problem, problem.initial, accepted, options);
        ADD_FAILURE() << name << " " << wrong;
      } catch (const SettingsError& error) {
        EXPECT_EQ(std::string(error.what()).rfind(name, 0), 0U) << error.what();
      }
      EXPECT_THROW(make_decisions(problem, problem.initial, accepted, options), SettingsError);
      EXPECT_THROW(mixture_graph(problem, options), SettingsError);
    }
  }
}

TEST(MixtureGraph, VerdictsAreProbabilitiesOfTheMixture) {
  const PoseGraph graph = chain<SE2>(12);
  const RobustProblem problem = to_robust_problem(graph, initialize_from_odometry(graph));
  const std::vector<bool> accepted(9, true);
  const std::vector<ClosureDecision> decisions = make_decisions(problem, problem.initial, accepted);
  const HybridGraph hybrid = mixture_graph(problem);
  std::size_t k = 0;
  hybrid.hybrid().for_each([&](Handle, const HybridFactorPtr& factor) {
    const Table table = factor->given(problem.initial)[0];
    const double odds = std::exp(table.costs()[1] - table.costs()[0]);
    EXPECT_NEAR(decisions[k].inlier_probability, odds / (1.0 + odds), 1e-9);
    EXPECT_NEAR(decisions[k].chi_square, 2.0 * problem.closures[k]->cost(problem.initial), 1e-12);
    ++k;
  });
  EXPECT_EQ(k, 9u);
}

template <class Pose>
void expect_protocol(const PoseGraph& graph, std::vector<GraphEdge<Pose>> PoseGraph::*edges) {
  const std::size_t before = (graph.*edges).size();
  const PoseGraph half = add_false_closures(graph, 0.5, 4);
  const std::size_t closures = before - 199;
  ASSERT_EQ((half.*edges).size(), before + closures);
  std::set<std::pair<Key, Key>> pairs;
  double largest = 0.0;
  for (std::size_t e = before; e < (half.*edges).size(); ++e) {
    const auto& edge = (half.*edges)[e];
    pairs.emplace(edge.from, edge.to);
    const auto t = edge.measured.translation();
    largest = std::max(largest, t.cwiseAbs().maxCoeff());
    EXPECT_GT(std::abs(double(edge.from.index()) - double(edge.to.index())), 1.5);
  }
  EXPECT_LE(largest, 5.0);
  EXPECT_GT(largest, 4.5);
  EXPECT_GT(pairs.size(), closures - 10);
  EXPECT_EQ((add_false_closures(graph, 0.8, 4).*edges).size(), before + 4 * closures);
  EXPECT_EQ((add_false_closures(graph, 0.0, 4).*edges).size(), before);
  const PoseGraph again = add_false_closures(graph, 0.5, 4);
  const PoseGraph other = add_false_closures(graph, 0.5, 5);
  EXPECT_EQ((again.*edges).back().from, (half.*edges).back().from);
  EXPECT_NE((other.*edges).back().measured.translation().x(),
            (half.*edges).back().measured.translation().x());
}

TEST(Outliers, FollowTheProtocol) {
  expect_protocol(chain<SE2>(200), &PoseGraph::poses2);
  expect_protocol(chain<SE3>(200), &PoseGraph::poses3);
  EXPECT_THROW(add_false_closures(chain<SE2>(20), 1.0, 1), Error);
  EXPECT_THROW(add_false_closures(chain<SE2>(20), -0.1, 1), Error);
}

}  // namespace
}  // namespace hybrid
