// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, the hybrid mapping authors
#include "libhybrid/baselines/consistency.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <random>

#include "libhybrid/baselines/detail/clique.h"
#include "libhybrid/baselines/least_squares.h"
#include "tests/support/corrupted_graph.h"

namespace hybrid {
namespace {

Adjacency random_graph(int size, double density, unsigned seed) {
  std::mt19937 rng(seed);
  std::bernoulli_distribution joined(density);
  Adjacency graph(size);
  for (int a = 0; a < size; ++a) {
    for (int b = 0; b < a; ++b) {
      if (joined(rng)) graph.join(a, b);
    }
  }
  return graph;
}

bool is_clique(const Adjacency& graph, const std::vector<int>& vertices) {
  for (std::size_t i = 0; i < vertices.size(); ++i) {
    for (std::size_t j = 0; j < i; ++j) {
      if (!graph.joined(vertices[i], vertices[j])) return false;
    }
  }
  return true;
}

std::size_t largest_by_enumeration(const Adjacency& graph) {
  std::size_t largest = 0;
  for (unsigned set = 0; set < (1u << graph.size()); ++set) {
    std::vector<int> vertices;
    for (int v = 0; v < graph.size(); ++v) {
      if (set >> v & 1) vertices.push_back(v);
    }
    if (vertices.size() > largest && is_clique(graph, vertices)) largest = vertices.size();
  }
  return largest;
}

TEST(Clique, EqualsEnumeration) {
  for (unsigned seed = 0; seed < 40; ++seed) {
    const Adjacency graph = random_graph(3 + seed % 12, 0.2 + 0.02 * seed, seed);
    const Clique clique = largest_clique(graph, 1000000);
    EXPECT_TRUE(clique.exact);
    EXPECT_TRUE(is_clique(graph, clique.vertices));
    EXPECT_EQ(clique.vertices.size(), largest_by_enumeration(graph)) << seed;
  }
}

TEST(Clique, FindsAPlantedOneAcrossWords) {
  Adjacency graph = random_graph(300, 0.3, 5);
  for (int a = 0; a < 300; a += 10) {
    for (int b = 0; b < a; b += 10) graph.join(a, b);
  }
  const Clique clique = largest_clique(graph, 1000000);
  EXPECT_TRUE(clique.exact);
  EXPECT_GE(clique.vertices.size(), 30u);
  EXPECT_TRUE(is_clique(graph, clique.vertices));
}

TEST(Clique, StopsAtItsLimitAndSaysSo) {
  const Adjacency graph = random_graph(200, 0.9, 1);
  const Clique limited = largest_clique(graph, 50);
  EXPECT_FALSE(limited.exact);
  EXPECT_TRUE(is_clique(graph, limited.vertices));
  EXPECT_FALSE(limited.vertices.empty());
  EXPECT_FALSE(largest_clique(graph, 0).exact);
  EXPECT_TRUE(largest_clique(Adjacency(0), 10).vertices.empty());
}

/// Errors of closed loops, drawn by simulation, have the chi-square distribution they are judged
/// by.
template <class Group>
double share_of_agreeing_pairs(double probability) {
  std::size_t pairs = 0, all = 0;
  for (unsigned seed = 0; seed < 40; ++seed) {
    std::mt19937 rng(seed);
    RobustProblem problem;
    const double sigma = 0.01;
    const Noise noise = Noise::isotropic(Group::kDim, sigma);
    std::vector<Group> truth = {Group()};
    for (int i = 1; i < 40; ++i) {
      const Group motion = testing::random_motion<Group>(0.3, rng);
      truth.push_back(truth.back() * motion);
      problem.trusted.push_back(std::make_shared<Between<Group>>(
          testing::pose(i - 1), testing::pose(i),
          motion * testing::random_motion<Group>(sigma, rng), noise));
    }
    // Backwards and forwards, and ways between them that share no odometry.
    for (const auto& [a, b] : {std::pair{0, 30}, std::pair{39, 10}}) {
      const Group measured = truth[a].between(truth[b]) * testing::random_motion<Group>(sigma, rng);
      problem.closures.push_back(
          std::make_shared<Between<Group>>(testing::pose(a), testing::pose(b), measured, noise));
    }
    const std::pair<int, int> other = seed % 2 == 0 ? std::pair{5, 36} : std::pair{20, 25};
    problem.closures[1] = std::make_shared<Between<Group>>(
        testing::pose(other.first), testing::pose(other.second),
        truth[other.first].between(truth[other.second]) * testing::random_motion<Group>(sigma, rng),
        noise);
    ConsistencyOptions options;
    options.probability = probability;
    pairs += pairwise_consistency(problem, options).pairs;
    ++all;
  }
  return double(pairs) / double(all);
}

TEST(Consistency, TrueClosuresAgreeAsOftenAsSaid) {
  EXPECT_NEAR(share_of_agreeing_pairs<SE2>(0.5), 0.5, 0.25);
  EXPECT_NEAR(share_of_agreeing_pairs<SE3>(0.5), 0.5, 0.25);
  EXPECT_GT(share_of_agreeing_pairs<SE2>(0.999), 0.95);
  EXPECT_GT(share_of_agreeing_pairs<SE3>(0.999), 0.95);
}

/// How many pairs agree of four closures at the end of a way whose first part, `lead` long, none of
/// their loops uses; two of them are off by some standard deviations.
template <class Group>
std::size_t agreeing_pairs_after(double lead) {
  std::mt19937 rng(7);
  RobustProblem problem;
  const Noise noise = Noise::isotropic(Group::kDim, 0.01);
  std::vector<Group> truth = {Group()};
  for (int i = 1; i < 140; ++i) {
    typename Group::Tangent v = 0.3 * Group::Tangent::Ones();
    if (i < 100) {
      v.setZero();
      v[0] = lead / 100;
    }
    truth.push_back(truth.back() * Group::exp(v));
    problem.trusted.push_back(std::make_shared<Between<Group>>(
        testing::pose(i - 1), testing::pose(i), Group::exp(v), noise));
  }
  int k = 0;
  for (const auto& [a, b] :
       {std::pair{102, 138}, std::pair{139, 101}, std::pair{110, 112}, std::pair{120, 125}}) {
    typename Group::Tangent error = Group::Tangent::Zero();
    error[0] = 0.03 * k++;
    // Between stops of the same shape wherever they lie.
    Group motion;
    typename Group::Tangent v = 0.3 * Group::Tangent::Ones();
    for (int i = std::min(a, b); i < std::max(a, b); ++i) motion = motion * Group::exp(v);
    if (a > b) motion = motion.inverse();
    problem.closures.push_back(std::make_shared<Between<Group>>(testing::pose(a), testing::pose(b),
                                                                motion * Group::exp(error), noise));
  }
  ConsistencyOptions options;
  options.probability = 0.5;
  return pairwise_consistency(problem, options).pairs;
}

TEST(Consistency, DoesNotDependOnTheWayBefore) {
  EXPECT_GT(agreeing_pairs_after<SE2>(0.0), 1u);
  EXPECT_LT(agreeing_pairs_after<SE2>(0.0), 6u);
  for (double lead : {1e3, 1e6, 1e9}) {
    EXPECT_EQ(agreeing_pairs_after<SE2>(lead), agreeing_pairs_after<SE2>(0.0)) << lead;
    EXPECT_EQ(agreeing_pairs_after<SE3>(lead), agreeing_pairs_after<SE3>(0.0)) << lead;
  }
}

template <class Group>
void expect_lies_filtered() {
  const auto g = testing::drive_laps<Group>(4, 30, 8);
  ConsistencyOptions options;
  options.probability = 0.9999;
  const Consistency result = pairwise_consistency(g.problem, options);
  EXPECT_EQ(result.compared, g.truth.size());
  std::size_t kept_true = 0, kept_false = 0;
  for (std::size_t k = 0; k < g.truth.size(); ++k) {
    if (result.kept[k]) ++(g.truth[k] ? kept_true : kept_false);
  }
  EXPECT_LE(kept_false, 1u);
  EXPECT_GE(kept_true, 30u);
}

TEST(Consistency, FiltersLies) {
  expect_lies_filtered<SE2>();
  expect_lies_filtered<SE3>();
}

TEST(Consistency, SolvesWhatIsLeft) {
  const auto g = testing::drive_laps<SE2>(4, 30, 8);
  ConsistencyOptions options;
  options.probability = 0.9999;
  const RobustResult result =
      solve_consistent(g.problem, options, {}, [](const RobustProblem& p) { return solve_lm(p); });
  EXPECT_EQ(result.method, "lm+consistency");
  ASSERT_EQ(result.decisions.size(), g.truth.size());
  const RobustResult told = solve_given(g.problem, g.truth);
  EXPECT_LT(testing::largest_error<SE2>(result.values, told.values), 0.05);
  std::vector<bool> accepted;
  for (const ClosureDecision& decision : result.decisions) accepted.push_back(decision.accepted());
  EXPECT_NEAR(result.objective, joint_objective(g.problem, result.values, accepted).objective,
              1e-9);
}

TEST(Consistency, LeavesAloneWhatItCannotJudge) {
  auto g = testing::drive_laps<SE2>(2, 4, 8);
  g.problem.trusted.clear();  // no odometry
  const Consistency result = pairwise_consistency(g.problem);
  EXPECT_EQ(result.compared, 0u);
  EXPECT_EQ(std::count(result.kept.begin(), result.kept.end(), true),
            static_cast<long>(g.truth.size()));
  ConsistencyOptions options;
  options.probability = 1.0;
  EXPECT_THROW(pairwise_consistency(g.problem, options), Error);
  const auto whole = testing::drive_laps<SE2>(2, 4, 8);
  options = {};
  options.max_closures = 3;
  EXPECT_THROW(pairwise_consistency(whole.problem, options), Error);
}

}  // namespace
}  // namespace hybrid
