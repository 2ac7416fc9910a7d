// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, the hybrid mapping authors
#include "libhybrid/solvers/levenberg_marquardt.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <limits>
#include <stdexcept>

#include "libhybrid/factors/bearing.h"
#include "tests/support/simulated_graphs.h"

namespace hybrid {
namespace {

using testing::pose;

bool falls(const std::vector<double>& costs) {
  return std::is_sorted(costs.rbegin(), costs.rend());
}

/// Half the squared norm of the gradient by differences of the cost: zero at a minimum.
double gradient_by_differences(const HybridGraph& graph, const Values& values) {
  const double h = 1e-5;
  double largest = 0.0;
  for (Key key : values.keys()) {
    for (int i = 0; i < values.type(key).dim; ++i) {
      double costs[2];
      for (int side = 0; side < 2; ++side) {
        Values moved = values;
        Eigen::VectorXd d = Eigen::VectorXd::Zero(values.type(key).dim);
        d[i] = side == 0 ? h : -h;
        const int slot = moved.slot(key);
        retract(moved.type(slot), values.data(slot), d.data(), moved.data(slot));
        costs[side] = cost(graph, moved, {});
      }
      largest = std::max(largest, std::abs(costs[0] - costs[1]) / (2.0 * h));
    }
  }
  return largest;
}

template <class Group>
class LevenbergMarquardtOf : public ::testing::Test {};
using Groups = ::testing::Types<SE2, SE3>;
TYPED_TEST_SUITE(LevenbergMarquardtOf, Groups);

TYPED_TEST(LevenbergMarquardtOf, ReachesAStationaryPointNearTheTruth) {
  const auto s = testing::simulate_loops<TypeParam>(60, 40, 0.02, 1);
  SolverOptions options;
  options.relative_decrease = 1e-12;
  const SolverResult result = levenberg_marquardt(s.graph, s.initial, options);
  EXPECT_EQ(result.report.status, SolverStatus::kConverged) << result.report.message;
  EXPECT_TRUE(falls(result.report.costs));
  EXPECT_LT(gradient_by_differences(s.graph, result.values), 1e-2);
  EXPECT_LT(testing::distance(result.values, s.truth), 0.4);
  EXPECT_GT(testing::distance(s.initial.values, s.truth), 0.5);
  EXPECT_NEAR(result.report.final_cost(), cost(s.graph, result.values, {}), 1e-9);
}

TYPED_TEST(LevenbergMarquardtOf, ReachesTheExactSolutionWithoutNoise) {
  auto s = testing::simulate_loops<TypeParam>(40, 20, 1e-12, 2);
  std::mt19937 rng(3);
  for (int i = 1; i < 40; ++i) {
    s.initial.values.update(pose(i), s.truth.template at<TypeParam>(pose(i)) *
                                         testing::random_motion<TypeParam>(0.1, rng));
  }
  const SolverResult result = levenberg_marquardt(s.graph, s.initial);
  EXPECT_LT(testing::distance(result.values, s.truth), 1e-8);
}

TYPED_TEST(LevenbergMarquardtOf, IsTheSameForAnyNumberOfThreads) {
  const auto s = testing::simulate_loops<TypeParam>(1500, 700, 0.01, 4);
  SolverOptions one, two;
  one.threads = 1;
  two.threads = 2;
  const SolverResult a = levenberg_marquardt(s.graph, s.initial, one);
  const SolverResult b = levenberg_marquardt(s.graph, s.initial, two);
  EXPECT_EQ(a.report.costs, b.report.costs);
  for (Key key : a.values.keys()) {
    EXPECT_TRUE(
        std::equal(a.values.data(key), a.values.data(key) + TypeParam::kSize, b.values.data(key)));
  }
}

TEST(LevenbergMarquardt, SolvesALinearProblemInOneStep) {
  using Point = Eigen::Vector2d;
  HybridGraph graph;
  Estimate initial;
  initial.values.insert(Key('p', 0), Point(100.0, -30.0));
  graph.emplace<Prior<Point>>(Key('p', 0), Point(1.0, 2.0), Noise::isotropic(2, 1.0));
  graph.emplace<Prior<Point>>(Key('p', 0), Point(3.0, 6.0), Noise::isotropic(2, 1.0));
  const SolverResult result = levenberg_marquardt(graph, initial);
  EXPECT_LE(result.report.iterations, 2);
  EXPECT_NEAR(result.report.costs.at(1), result.report.final_cost(), 1e-12);
  EXPECT_LT((result.values.at<Point>(Key('p', 0)) - Point(2.0, 4.0)).norm(), 1e-12);
}

TEST(LevenbergMarquardt, SurvivesAStartFarAway) {
  auto s = testing::simulate_loops<SE2, BetweenSE2>(50, 100, 0.05, 5);
  std::mt19937 rng(6);
  for (int i = 1; i < 50; ++i) {
    s.initial.values.update(pose(i), testing::random_motion<SE2>(10.0, rng));
  }
  const SolverResult result = levenberg_marquardt(s.graph, s.initial);
  EXPECT_TRUE(falls(result.report.costs));
  EXPECT_LT(result.report.final_cost(), result.report.costs.front());
}

TEST(LevenbergMarquardt, NamesAllPosesOfAGraphWithoutPrior) {
  auto s = testing::simulate_loops<SE2>(30, 20, 0.05, 7);
  s.graph.remove(s.graph.continuous().handle(0));
  const SolverResult result = levenberg_marquardt(s.graph, s.initial);
  EXPECT_EQ(result.report.status, SolverStatus::kUnderConstrained);
  EXPECT_EQ(result.report.under_constrained.size(), 30u);
  EXPECT_LT(result.report.final_cost(), 0.5 * result.report.costs.front());
}

TEST(LevenbergMarquardt, NamesALandmarkSeenByOneBearing) {
  auto s = testing::simulate_loops<SE2>(10, 5, 0.05, 8);
  s.graph.emplace<Bearing2>(pose(3), Key('l', 7), Bearing2::Angles(0.3), Noise::isotropic(1, 0.01));
  s.initial.values.insert(Key('l', 7), Eigen::Vector2d(4.0, 5.0));
  const SolverResult result = levenberg_marquardt(s.graph, s.initial);
  EXPECT_EQ(result.report.status, SolverStatus::kUnderConstrained);
  EXPECT_EQ(result.report.under_constrained, std::vector<Key>{Key('l', 7)});
  EXPECT_NE(result.report.message.find("l7"), std::string::npos);
}

TEST(LevenbergMarquardt, DoesNotBlameALongChain) {
  const auto s = testing::simulate_loops<SE2, BetweenSE2>(10000, 0, 0.01, 9);
  const SolverResult result = levenberg_marquardt(s.graph, s.initial);
  EXPECT_EQ(result.report.status, SolverStatus::kConverged) << result.report.message;
}

/// A factor that is not defined everywhere.
struct Root : FactorOf<1, Eigen::Matrix<double, 1, 1>> {
  using V = Eigen::Matrix<double, 1, 1>;
  explicit Root(Key key) : FactorOf({key}, Noise::unit(1)) {}
  std::string name() const override { return "root"; }
  Residual evaluate(const V& x, Jacobian<V>* J) const override {
    if (J != nullptr) (*J)(0) = 0.5 / std::sqrt(x[0]);
    return Residual(std::sqrt(x[0]) - 1.0);
  }
};

TEST(LevenbergMarquardt, ReportsWhatIsNotANumber) {
  for (double start : {-1.0, 0.0}) {  // no residual; a residual without a derivative
    HybridGraph graph;
    graph.emplace<Root>(Key('x', 0));
    Estimate initial;
    initial.values.insert(Key('x', 0), Root::V(start));
    const SolverResult result = levenberg_marquardt(graph, initial);
    EXPECT_EQ(result.report.status, SolverStatus::kNotFinite) << start;
    EXPECT_EQ(result.values.at<Root::V>(Key('x', 0))[0], start);
  }
}

/// A factor of a user that cannot take its variable.
struct Thrower : FactorOf<6, Eigen::Matrix<double, 6, 1>> {
  using V = Eigen::Matrix<double, 6, 1>;
  Thrower(Key key, bool throws) : FactorOf({key}, Noise::unit(6)), throws(throws) {}
  std::string name() const override { return "thrower"; }
  Residual evaluate(const V& x, Jacobian<V>* J) const override {
    if (J != nullptr && throws) throw std::domain_error("bad measurement");
    if (J != nullptr) J->setIdentity();
    return x;
  }
  bool throws;
};

TEST(LevenbergMarquardt, HandsOnWhatAFactorThrowsInWhateverThread) {
  for (int n : {100, 3000}) {  // too few to share, and many
    HybridGraph graph;
    Estimate initial;
    for (int i = 0; i < n; ++i) {
      initial.values.insert(Key('x', i), Thrower::V(Thrower::V::Ones()));
      graph.emplace<Thrower>(Key('x', i), i == n - 1);
    }
    for (int threads : {1, 2, 4}) {
      SolverOptions options;
      options.threads = threads;
      EXPECT_THROW(levenberg_marquardt(graph, initial, options), std::domain_error);
    }
  }
}

TEST(LevenbergMarquardt, NamesAVariableWithoutValueOrOfAnotherType) {
  auto s = testing::simulate_loops<SE2>(5, 2, 0.05, 11);
  s.graph.emplace<Prior<SE2>>(Key('y', 1), SE2(), Noise::unit(3));
  EXPECT_THROW(levenberg_marquardt(s.graph, s.initial), Error);
  s.initial.values.insert(Key('y', 1), SE3());
  EXPECT_THROW(levenberg_marquardt(s.graph, s.initial), Error);
}

TEST(LevenbergMarquardt, StopsAtTheIterationLimit) {
  const auto s = testing::simulate_loops<SE2>(60, 40, 0.05, 12);
  SolverOptions options;
  options.max_iterations = 1;
  const SolverResult result = levenberg_marquardt(s.graph, s.initial, options);
  EXPECT_EQ(result.report.status, SolverStatus::kIterationLimit);
  EXPECT_EQ(result.report.iterations, 1);
}

}  // namespace
}  // namespace hybrid
