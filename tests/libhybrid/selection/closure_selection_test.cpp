// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, the hybrid mapping authors
#include "libhybrid/selection/closure_selection.h"

#include <gtest/gtest.h>

#include <cmath>
#include <filesystem>

#include "libhybrid/baselines/alternation.h"
#include "libhybrid/baselines/least_squares.h"
#include "libhybrid/factors/between.h"
#include "libhybrid/io/read_graph.h"
#include "libhybrid/methods/portfolio.h"
#include "libhybrid/pose_graph/false_closures.h"
#include "libhybrid/selection/closure_posterior.h"
#include "libhybrid/selection/evidence.h"
#include "libhybrid/selection/innovation.h"
#include "libhybrid/solvers/chordal.h"
#include "tests/support/data_path.h"
#include "tests/support/random.h"
#include "tests/support/simulated_graphs.h"

namespace hybrid {
namespace {

/// A robot drives laps around a square of side 10 m, measures its way and recognises places of the
/// lap before; a lie closes the same pair of places wrongly several times, each time alike.
struct Laps {
  PoseGraph graph;
  std::size_t true_closures = 0;
};

SE2 place(int k) {
  const int side = k % 40 / 10;
  const double along = k % 10;
  const SE2 corner(side == 1 || side == 2 ? 10.0 : 0.0, side >= 2 ? 10.0 : 0.0, 0.5 * M_PI * side);
  return corner * SE2(along, 0.0, 0.0);
}

Laps drive(int poses, int lies, std::uint64_t seed,
           const Eigen::Vector3d& sigmas = {0.02, 0.02, 0.005}) {
  testing::Random random(seed);
  const Noise noise = Noise::diagonal(sigmas);
  const auto measured = [&](const SE2& a, const SE2& b) {
    const Eigen::Vector3d e(random.normal(sigmas[0]), random.normal(sigmas[1]),
                            random.normal(sigmas[2]));
    return a.inverse() * b * SE2::exp(e);
  };
  Laps laps;
  for (int k = 1; k < poses; ++k) {
    laps.graph.poses2.push_back(
        {Key('x', k - 1), Key('x', k), measured(place(k - 1), place(k)), noise});
  }
  for (int k = 40; k < poses; k += 2) {
    laps.graph.poses2.push_back(
        {Key('x', k), Key('x', k - 40), measured(place(k), place(k - 40)), noise});
    ++laps.true_closures;
  }
  for (int k = 0; k < lies; ++k) {  // pose 60 + k is 5 m away from where it claims to be
    laps.graph.poses2.push_back(
        {Key('x', 60 + k), Key('x', 5 + k), measured(place(60 + k), place(60 + k)), noise});
  }
  return laps;
}

RobustProblem problem_of(const PoseGraph& graph) {
  return to_robust_problem(graph, initialize_from_odometry(graph));
}

int accepted(const RobustResult& result, std::size_t begin, std::size_t end) {
  int count = 0;
  for (std::size_t k = begin; k < end; ++k) count += result.decisions[k].accepted() ? 1 : 0;
  return count;
}

TEST(ClosureSelection, IsTheOptimumWhereNoClosureIsFalse) {
  const RobustProblem problem = problem_of(drive(120, 0, 1).graph);
  const RobustResult robust = select_closures(problem);
  const RobustResult plain = solve_lm(problem);
  EXPECT_TRUE(robust.converged) << robust.message;
  EXPECT_NEAR(robust.cost, plain.cost, 1e-6 * plain.cost);
  EXPECT_LT(testing::distance(robust.values, plain.values), 1e-4);
  EXPECT_EQ(accepted(robust, 0, problem.closures.size()), 40);
  EXPECT_NEAR(std::log(robust.variance_factor), 0.0, 1.0);
  for (const ClosureDecision& decision : robust.decisions) {
    EXPECT_TRUE(decision.checkable);
    EXPECT_GT(decision.inlier_probability, 0.99);
    EXPECT_GT(decision.margin, 0.0);
  }
}

TEST(ClosureSelection, FalseClosuresThatAgreeWithEachOtherStayOut) {
  const Laps laps = drive(120, 15, 2);
  const RobustProblem problem = problem_of(laps.graph);
  const RobustResult robust = select_closures(problem);
  EXPECT_EQ(accepted(robust, 0, laps.true_closures), 40);
  EXPECT_EQ(accepted(robust, laps.true_closures, problem.closures.size()), 0);
  EXPECT_LT(robust.decisions.back().inlier_probability, 0.01);

  RobustProblem only_lies = problem;  // a map of lies alone stays the odometry
  only_lies.closures.erase(only_lies.closures.begin(),
                           only_lies.closures.begin() + std::ptrdiff_t(laps.true_closures));
  const RobustResult none = select_closures(only_lies);
  EXPECT_EQ(accepted(none, 0, only_lies.closures.size()), 0);
  EXPECT_LT(testing::distance(none.values, problem.initial), 1e-6);
}

/// The selection finds most false closures by a bound of their evidence, which is no probability.
TEST(ClosureSelection, AFalseClosureIsAsImprobableAsItsInnovationSays) {
  for (const unsigned seed : {1, 2, 3}) {
    const Laps laps = drive(160, 0, seed, {0.1, 0.1, 0.05});
    const RobustProblem problem = problem_of(add_false_closures(laps.graph, 0.8, seed));
    const RobustResult result = select_closures(problem, {});
    RobustResult integrated = result;
    integrated.poses_integrated = false;
    integrate_poses(problem, {}, integrated);
    int improbable = 0;
    for (std::size_t k = laps.true_closures; k < result.decisions.size(); ++k) {
      if (integrated.decisions[k].inlier_probability > 1e-6) continue;
      EXPECT_LT(result.decisions[k].inlier_probability, 0.5) << "seed " << seed << ", " << k;
      ++improbable;
    }
    EXPECT_GT(improbable, 200);
  }
}

/// Information one for metres and radians, as in files that state none: no innovation could tell a
/// true closure from a false one in a map so small.
TEST(ClosureSelection, AcceptsWhatFitsWithoutInformation) {
  const Noise unit = Noise::diagonal(Eigen::Vector3d(1.0, 1.0, 1.0));
  PoseGraph square;
  const SE2 side(2.0, 0.0, 0.5 * M_PI);
  for (int k = 0; k < 4; ++k) {
    square.poses2.push_back({Key('x', k), Key('x', k + 1), side, unit});
  }
  square.poses2.push_back({Key('x', 4), Key('x', 0), SE2(), unit});
  EXPECT_EQ(accepted(select_closures(problem_of(square)), 0, 1), 1);
  square.poses2.back().measured = SE2(40.0, 0.0, 0.0);
  EXPECT_EQ(accepted(select_closures(problem_of(square)), 0, 1), 0);
}

TEST(ClosureSelection, EveryMacroStepLowersTheObjective) {
  for (unsigned seed = 1; seed <= 5; ++seed) {
    const PoseGraph graph = add_false_closures(drive(200, 0, seed).graph, 0.6, seed);
    const RobustProblem problem = problem_of(graph);
    const RobustResult robust = select_closures(problem);
    ASSERT_GT(robust.objectives.size(), 1u);
    for (std::size_t i = 1; i < robust.objectives.size(); ++i) {
      EXPECT_LT(robust.objectives[i], robust.objectives[i - 1]) << "seed " << seed;
    }
    std::vector<bool> in;
    for (const ClosureDecision& decision : robust.decisions) in.push_back(decision.accepted());
    const JointObjective joint = joint_objective(problem, robust.values, in);
    EXPECT_NEAR(joint.objective, robust.objective, 1e-6);
    EXPECT_EQ(accepted(robust, 0, 80), 80);
    // A random lie may happen to be true: only such a one may be in.
    Values truth;
    for (int k = 0; k < 200; ++k) truth.insert(Key('x', k), place(k));
    for (std::size_t k = 80; k < in.size(); ++k) {
      const ContinuousFactor& lie = *problem.closures[k];
      EXPECT_TRUE(!in[k] || 2.0 * lie.cost(truth) < gate_quantile(lie.rows())) << "seed " << seed;
    }
  }
}

TEST(ClosureSelection, SameResultForAnyNumberOfThreads) {
  const PoseGraph graph = add_false_closures(drive(200, 5, 3).graph, 0.5, 3);
  ClosureSelectionOptions one, three;
  one.solver.threads = 1;
  three.solver.threads = 3;
  const RobustResult a = select_closures(problem_of(graph), one);
  const RobustResult b = select_closures(problem_of(graph), three);
  EXPECT_EQ(a.objective, b.objective);
  EXPECT_LT(testing::distance(a.values, b.values), 1e-16);  // x minus x, rounded
}

TEST(ClosureSelection, FlagsWhatNothingElseChecks) {
  Laps laps = drive(60, 0, 4);
  // Odometry and one closure of a long way.
  laps.graph.poses2.erase(laps.graph.poses2.begin() + 60, laps.graph.poses2.end());
  const RobustProblem problem = problem_of(laps.graph);
  const RobustResult robust = select_closures(problem);
  ASSERT_EQ(robust.decisions.size(), 1u);
  EXPECT_LT(robust.decisions[0].redundancy, 0.09);
  EXPECT_FALSE(robust.decisions[0].checkable);
  ClosureSelectionOptions strict;
  strict.refuse_uncheckable = true;
  EXPECT_FALSE(select_closures(problem, strict).decisions[0].accepted());
}

TEST(ClosureSelection, RedundancyIsTheReducedIdentity) {
  const RobustProblem problem = problem_of(drive(60, 0, 5).graph);
  const RobustResult robust = select_closures(problem);
  HybridGraph graph(problem.trusted);
  for (const auto& closure : problem.closures) graph.add(closure);
  Problem all(graph, robust.values, {});
  const Problem::State state = all.load(robust.values);
  all.linearize(state);
  all.assemble();
  ASSERT_EQ(all.factorize(0.0), -1);
  double sum = 0.0;  // of redundancies, that of trusted factors included: rows minus unknowns
  InnovationPredictor predictor(all, state);
  graph.continuous().for_each([&](Handle, const ContinuousFactorPtr& factor) {
    sum += factor->rows() - predictor.predict(*factor).APAt.trace();
  });
  EXPECT_NEAR(sum, 3.0 * double(graph.size()) - 3.0 * 60, 1e-6);
  for (std::size_t k = 0; k < problem.closures.size(); ++k) {
    const double trace = predictor.predict(*problem.closures[k]).APAt.trace();
    EXPECT_NEAR(robust.decisions[k].redundancy, 1.0 - trace / 3.0, 1e-6);
  }
}

TEST(ClosureSelection, BadInput) {
  const PoseGraph graph = drive(60, 0, 6).graph;
  RobustProblem none = problem_of(graph);
  none.closures.clear();
  const RobustResult odometry = select_closures(none);
  EXPECT_TRUE(odometry.decisions.empty());
  EXPECT_TRUE(odometry.converged);

  RobustProblem twice = problem_of(graph);
  const std::size_t count = twice.closures.size();
  for (std::size_t k = 0; k < count; ++k) twice.closures.push_back(twice.closures[k]);
  EXPECT_EQ(accepted(select_closures(twice), 0, 2 * count), int(2 * count));

  RobustProblem gap = problem_of(graph);  // odometry is missing between poses 29 and 30
  gap.trusted.erase(gap.trusted.begin() + 29);
  try {
    select_closures(gap);
    FAIL() << "a trajectory in two parts";
  } catch (const Error& e) {
    EXPECT_NE(std::string(e.what()).find("undetermined"), std::string::npos) << e.what();
  }
}

TEST(Evidence, VarianceFactorIsThatOfTheSample) {
  testing::Random random(9);
  std::vector<double> chi_squares;
  for (int k = 0; k < 2000; ++k) {
    chi_squares.push_back(0.05 * random.vector<3>().squaredNorm());
    if (k % 5 == 0) chi_squares.back() = 1e4;  // lies
  }
  const std::vector<int> degrees(chi_squares.size(), 3);
  EXPECT_NEAR(variance_factor(chi_squares, degrees, 0.2), 0.05, 0.02);
  EXPECT_EQ(variance_factor({}, {}), 1.0);
}

TEST(Alternation, IsStuckWhereReadmissionIsNot) {
  const std::string file = testing::data_path("pose_graphs/CSAIL.g2o");
  if (!std::filesystem::exists(file)) GTEST_SKIP() << file << " is not there";
  const PoseGraph clean = read_graph(file);
  const Values optimum = solve_lm(problem_of(clean)).values;
  for (double rate : {0.0, 0.8}) {
    const RobustProblem problem = problem_of(add_false_closures(clean, rate, 77));
    const RobustResult robust = select_closures(problem);
    EXPECT_EQ(accepted(robust, 0, 128), 128);
    EXPECT_LT(testing::distance(robust.values, optimum), 0.05);
    EXPECT_LT(accepted(solve_alternating(problem), 0, 128), 128);
  }
}

template <class Group, class Factor>
void expect_chordal() {
  // Without noise, the linear systems give the exact poses however wrong the start.
  const auto simulated = testing::simulate_loops<Group, Factor>(60, 30, 1e-9, 5);
  std::vector<ContinuousFactorPtr> factors;
  simulated.graph.continuous().for_each(
      [&](Handle, const ContinuousFactorPtr& factor) { factors.push_back(factor); });
  Values wild = simulated.initial.values;
  testing::Random random(8);
  for (Key key : wild.keys()) {
    if (key.index() > 0) wild.update(key, random.value<Group>());
  }
  const Values values = chordal_initialization(factors, wild);
  EXPECT_LT(testing::distance(values, simulated.truth), 1e-5);
}

TEST(Chordal, RecoversPosesFromAnyStart) {
  expect_chordal<SE2, BetweenSE2>();
  expect_chordal<SE2, Between<SE2>>();
  expect_chordal<SE3, Between<SE3>>();
}

TEST(Portfolio, ReturnsTheLowestVerifiedObjective) {
  const PoseGraph graph = add_false_closures(drive(120, 6, 7).graph, 0.4, 7);
  const RobustProblem problem = problem_of(graph);
  const RobustResult portfolio = solve_portfolio(problem);
  ASSERT_EQ(portfolio.members.size(), 5u);
  for (const MemberSummary& member : portfolio.members) {
    EXPECT_GE(member.verified_objective, portfolio.objective) << member.method;
    EXPECT_FALSE(member.method.empty());
  }
  EXPECT_EQ(accepted(portfolio, 0, 40), 40);
}

}  // namespace
}  // namespace hybrid
