// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, the hybrid mapping authors

// "Converged" means a stationary point, and only that.
#include "libhybrid/solvers/detail/convergence.h"

#include <gtest/gtest.h>

#include "libhybrid/factors/bearing.h"
#include "libhybrid/factors/bearing_range.h"
#include "libhybrid/factors/between.h"
#include "libhybrid/factors/position.h"
#include "libhybrid/factors/range.h"
#include "libhybrid/solvers/alternating.h"
#include "libhybrid/solvers/dogleg.h"
#include "libhybrid/solvers/levenberg_marquardt.h"
#include "tests/support/dense_system.h"
#include "tests/support/hard_factors.h"
#include "tests/support/random.h"
#include "tests/support/simulated_graphs.h"

namespace hybrid {
namespace {

using Eigen::Vector2d;
using Eigen::Vector3d;
using testing::DenseSystem;
using testing::pose;
using testing::Valley;
using testing::WrongJacobian;

using Solver = SolverResult (*)(const HybridGraph&, const Estimate&, const SolverOptions&);
SolverResult by_lm(const HybridGraph& g, const Estimate& e, const SolverOptions& o) {
  return levenberg_marquardt(g, e, o);
}
SolverResult by_dogleg(const HybridGraph& g, const Estimate& e, const SolverOptions& o) {
  return dogleg(g, e, o);
}

class Convergence : public ::testing::TestWithParam<Solver> {
 protected:
  SolverResult solve(const HybridGraph& graph, const Estimate& initial,
                     const SolverOptions& options = {}) const {
    return GetParam()(graph, initial, options);
  }
};
INSTANTIATE_TEST_SUITE_P(Solvers, Convergence, ::testing::Values(&by_lm, &by_dogleg),
                         [](const auto& info) { return info.index == 0 ? "lm" : "dogleg"; });

/// What remains of a Gauss-Newton step at the end, as a share of the cost; an accepted last step
/// leaves less than it brought, and a problem of large residuals a share of that.
void expect_stationary(const HybridGraph& graph, const SolverResult& result, double tolerance,
                       const std::string& what) {
  const DenseSystem at(graph, {result.values, {}});
  EXPECT_LE(at.promise(), 2.0 * tolerance * at.cost + 1e-12) << what;
}

TEST_P(Convergence, IsNotClaimedInsideAValley) {
  int early = 0;
  for (double steep : {10.0, 1e3}) {
    for (const Vector2d& start : {Vector2d(-1.2, 1.0), Vector2d(3.0, -4.0), Vector2d(-30.0, 7.0)}) {
      HybridGraph graph;
      graph.emplace<Valley>(Key('x', 0), steep);
      Estimate initial;
      initial.values.insert(Key('x', 0), start);
      for (int limit : {1, 2, 3, 5, 10, 20, 1000}) {
        SolverOptions options;
        options.max_iterations = limit;
        const SolverResult result = solve(graph, initial, options);
        const double off = (result.values.at<Vector2d>(Key('x', 0)) - Vector2d(1, 1)).norm();
        const bool converged = result.report.status == SolverStatus::kConverged;
        EXPECT_TRUE(!converged || off < 1e-6) << limit << ": " << off;
        // The steep one takes thousands of steps along its bend.
        EXPECT_TRUE(converged || limit < 1000 || steep > 10.0) << result.report.message;
        early += converged && limit < 1000 ? 1 : 0;
      }
    }
  }
  EXPECT_GT(early, 0);
}

// Whether the map may move as a whole does not depend on how good the start is.
TEST_P(Convergence, IsUnderConstrainedAtAPerfectStartToo) {
  for (const double off : {0.0, 0.3}) {
    HybridGraph graph;
    graph.emplace<BetweenSE2>(pose(0), pose(1), SE2(1.0, 0.0, 0.0), Noise::unit(3));
    Estimate initial;
    initial.values.insert(pose(0), SE2());
    initial.values.insert(pose(1), SE2(1.0 + off, 0.0, 0.0));
    const SolverReport report = solve(graph, initial).report;
    EXPECT_EQ(report.status, SolverStatus::kUnderConstrained) << report.message;
    EXPECT_EQ(report.under_constrained.size(), 2u);
  }
}

// The last step that the limit allows may be the one that arrives.
TEST_P(Convergence, IsSeenAtTheLimitOfIterations) {
  HybridGraph graph;
  graph.emplace<Prior<Vector2d>>(Key('x', 0), Vector2d(1, 2), Noise::isotropic(2, 0.1));
  Estimate initial;
  initial.values.insert(Key('x', 0), Vector2d(30.0, -4.0));
  SolverOptions options;
  options.max_iterations = 1;
  EXPECT_EQ(solve(graph, initial, options).report.status, SolverStatus::kConverged);
}

// Robust losses far from the minimum have wrong curvatures, and steps that are damped for long.
TEST_P(Convergence, IsAStationaryPointOfRobustProblems) {
  int converged = 0;
  for (unsigned seed = 0; seed < 60; ++seed) {
    auto s = testing::simulate_loops<SE2, BetweenSE2>(20, 0, 0.05, seed);
    std::mt19937 rng(seed);
    const Loss losses[] = {Loss::none(), Loss::huber(), Loss::cauchy(), Loss::geman_mcclure(3.0)};
    for (int k = 0; k < 15; ++k) {
      const int a = static_cast<int>(rng() % 20), b = static_cast<int>(rng() % 20);
      if (a == b) continue;
      const SE2 motion = s.truth.at<SE2>(pose(a)).between(s.truth.at<SE2>(pose(b))) *
                         testing::random_motion<SE2>(k % 3 == 0 ? 2.0 : 0.05, rng);
      s.graph.emplace<BetweenSE2>(pose(a), pose(b), motion, Noise::isotropic(3, 0.05),
                                  losses[seed % 4]);
    }
    for (int i = 1; i < 20; ++i) {
      const SE2 moved = s.truth.at<SE2>(pose(i)) * testing::random_motion<SE2>(1.0, rng);
      s.initial.values.update(pose(i), moved);
    }
    SolverOptions options;
    options.max_iterations = 1000;
    for (double tolerance : {1e-3, 1e-6, 1e-9}) {
      options.relative_decrease = tolerance;
      const SolverResult result = solve(s.graph, s.initial, options);
      if (result.report.status != SolverStatus::kConverged) continue;
      ++converged;
      expect_stationary(s.graph, result, tolerance, "seed " + std::to_string(seed));
    }
  }
  EXPECT_GT(converged, 150);
}

TEST_P(Convergence, IsNotClaimedWhereNoStepLowersTheCost) {
  HybridGraph graph;
  graph.emplace<WrongJacobian>(Key('x', 0));
  graph.emplace<Prior<Vector2d>>(Key('x', 0), Vector2d(0, 0), Noise::isotropic(2, 1e3));
  Estimate initial;
  initial.values.insert(Key('x', 0), Vector2d(0.0, 0.0));
  EXPECT_EQ(solve(graph, initial).report.status, SolverStatus::kStalled);
}

/// A chain of poses in a circle, a third of whose positions are measured, some hundreds of metres
/// off.
TEST_P(Convergence, IsClaimedWhereContradictionsLeaveNothingToGain) {
  for (int seed = 1; seed <= 10; ++seed) {
    testing::Random random(seed);
    HybridGraph graph;
    Estimate initial;
    SE2 truth;
    for (int i = 0; i < 60; ++i) {
      initial.values.insert(pose(i), truth);
      const SE2 motion(1, 0, 0.1);
      if (i > 0) {
        graph.emplace<BetweenSE2>(pose(i - 1), pose(i), motion,
                                  Noise::diagonal(Vector3d(0.02, 0.02, 0.002)));
      }
      if (i % 3 == 0) {
        const Vector2d off = i % 9 == 0 ? Vector2d(random.vector<2>(300)) : Vector2d::Zero();
        graph.emplace<Position<SE2>>(pose(i), Vector2d(truth.translation() + off),
                                     Noise::isotropic(2, 0.3));
      }
      truth = truth * motion;
    }
    SolverOptions options;
    options.max_iterations = 1000;
    const SolverReport report = solve(graph, initial, options).report;
    EXPECT_EQ(report.status, SolverStatus::kConverged) << "seed " << seed << ": " << report.message;
  }
}

// A landmark started at the sensor that saw it, as by a plugin that knows no better.
template <class Pose>
void expect_landmarks_leave_the_sensor(
    const std::function<SolverResult(const HybridGraph&, const Estimate&)>& solve) {
  using Point = typename Pose::Point;
  constexpr int kDim = Point::RowsAtCompileTime;
  for (unsigned seed = 1; seed <= 20; ++seed) {
    testing::Random random(seed);
    const Pose T = random.value<Pose>(), sensor = random.value<Pose>();
    const Point p = random.value<Point>(5.0);
    HybridGraph graph;
    graph.emplace<Prior<Pose>>(Key('x', 0), T, Noise::isotropic(Pose::kDim, 0.01));
    const BearingRange<Pose> unmeasured(Key('x', 0), Key('l', 0), Point::Ones(), Noise::unit(kDim),
                                        sensor);
    const Point z = unmeasured.predict(T, p);
    graph.emplace<BearingRange<Pose>>(Key('x', 0), Key('l', 0), z, Noise::isotropic(kDim, 0.05),
                                      sensor);
    Estimate initial;
    initial.values.insert(Key('x', 0), T);
    initial.values.insert(Key('l', 0), Point((T * sensor).translation()));
    const SolverResult result = solve(graph, initial);
    EXPECT_EQ(result.report.status, SolverStatus::kConverged) << result.report.message;
    EXPECT_LT((result.values.at<Point>(Key('l', 0)) - p).norm(), 1e-3) << "seed " << seed;
  }
}

TEST_P(Convergence, ALandmarkLeavesTheSensorItStartedAt) {
  const auto run = [&](const HybridGraph& g, const Estimate& e) { return solve(g, e); };
  expect_landmarks_leave_the_sensor<SE2>(run);
  expect_landmarks_leave_the_sensor<SE3>(run);
}

TEST_P(Convergence, APointLeavesTheAnchorItStartedAt) {
  // Three ranges to known points, the start at one of these or two points at one place.
  HybridGraph graph;
  const Vector2d p(2.0, 1.0);
  const Vector2d anchors[] = {{0.0, 0.0}, {4.0, 0.0}, {0.0, 5.0}};
  Estimate initial;
  for (int i = 0; i < 3; ++i) {
    initial.values.insert(Key('x', i), anchors[i]);
    graph.emplace<Prior<Vector2d>>(Key('x', i), anchors[i], Noise::isotropic(2, 0.01));
    graph.emplace<Range<Vector2d, Vector2d>>(Key('x', i), Key('l', 0), (p - anchors[i]).norm(),
                                             Noise::isotropic(1, 0.1));
  }
  initial.values.insert(Key('l', 0), anchors[0]);
  for (const Vector2d& start : anchors) {
    initial.values.update(Key('l', 0), start);
    const SolverResult result = solve(graph, initial);
    EXPECT_EQ(result.report.status, SolverStatus::kConverged) << result.report.message;
    EXPECT_LT((result.values.at<Vector2d>(Key('l', 0)) - p).norm(), 1e-3);
  }
}

// One range tells how far: the point goes there, and which way stays open.
TEST_P(Convergence, APointOfOneRangeIsAsFarAsMeasuredAndNotDetermined) {
  HybridGraph graph;
  graph.emplace<Prior<Vector2d>>(Key('x', 0), Vector2d(0, 0), Noise::isotropic(2, 0.1));
  graph.emplace<Range<Vector2d, Vector2d>>(Key('x', 0), Key('l', 0), 1.0, Noise::isotropic(1, 0.1));
  for (const Vector2d& start : {Vector2d(0, 0), Vector2d(1e-9, 0), Vector2d(3, 4)}) {
    Estimate initial;
    initial.values.insert(Key('x', 0), Vector2d(0, 0));
    initial.values.insert(Key('l', 0), start);
    const SolverResult result = solve(graph, initial);
    EXPECT_EQ(result.report.status, SolverStatus::kUnderConstrained) << result.report.message;
    EXPECT_EQ(result.report.under_constrained, std::vector<Key>{Key('l', 0)});
    EXPECT_LT(result.report.final_cost(), 1e-6);
    EXPECT_NEAR(result.values.at<Vector2d>(Key('l', 0)).norm(), 1.0, 1e-3);
  }
}

TEST_P(Convergence, BearingsPlaceAPointThatStartedAtOneOfTheSensors) {
  HybridGraph graph;
  const Vector2d p(3.0, 2.0);
  Estimate initial;
  for (int i = 0; i < 3; ++i) {
    const SE2 T(1.0 * i, -1.0 * i, 0.3 * i);
    initial.values.insert(Key('x', i), T);
    graph.emplace<Prior<SE2>>(Key('x', i), T, Noise::isotropic(3, 0.01));
    const Vector2d q = T.inverse() * p;
    graph.emplace<Bearing2>(Key('x', i), Key('l', 0), Bearing2::Angles(std::atan2(q.y(), q.x())),
                            Noise::isotropic(1, 0.01));
  }
  initial.values.insert(Key('l', 0), Vector2d(0.0, 0.0));
  const SolverResult result = solve(graph, initial);
  const double left = DenseSystem(graph, initial).cost;
  EXPECT_LT(result.report.final_cost(), left);
  if (result.report.status == SolverStatus::kConverged) {
    expect_stationary(graph, result, 1e-6, "bearings");
  }
}

// What was singular at the start need not be so at the end.
TEST_P(Convergence, ForgetsASingularityThatItLeft) {
  HybridGraph graph;
  // x^2 = 4 has no derivative at its start.
  struct Square : FactorOf<1, Eigen::Matrix<double, 1, 1>> {
    using V = Eigen::Matrix<double, 1, 1>;
    explicit Square(Key key) : FactorOf({key}, Noise::unit(1)) {}
    std::string name() const override { return "square"; }
    Residual evaluate(const V& x, Jacobian<V>* J) const override {
      if (J != nullptr) *J << 2.0 * x[0];
      return Residual(x[0] * x[0] - 4.0);
    }
  };
  struct Nudge : FactorOf<1, Eigen::Matrix<double, 1, 1>, Vector2d> {
    using V = Eigen::Matrix<double, 1, 1>;
    Nudge(Key a, Key b) : FactorOf({a, b}, Noise::unit(1)) {}
    std::string name() const override { return "nudge"; }
    Residual evaluate(const V& x, const Vector2d& y, Jacobian<V>* Jx,
                      Jacobian<Vector2d>* Jy) const override {
      if (Jx != nullptr) *Jx << y[0];
      if (Jy != nullptr) *Jy << x[0] - 1.0, 0.0;
      return Residual((x[0] - 1.0) * y[0]);
    }
  };
  graph.emplace<Square>(Key('x', 0));
  graph.emplace<Nudge>(Key('x', 0), Key('y', 0));
  graph.emplace<Prior<Vector2d>>(Key('y', 0), Vector2d(0.5, 0.0), Noise::unit(2));
  Estimate initial;
  initial.values.insert(Key('x', 0), Eigen::Matrix<double, 1, 1>(0.0));
  initial.values.insert(Key('y', 0), Vector2d(0.0, 0.0));  // x moves no residual here
  const SolverResult result = solve(graph, initial);
  EXPECT_EQ(result.report.status, SolverStatus::kConverged) << result.report.message;
  EXPECT_TRUE(result.report.under_constrained.empty());
  expect_stationary(graph, result, 1e-6, "square");
}

TEST(AlternatingConvergence, IsThatOfTheContinuousHalf) {
  HybridGraph graph;
  graph.emplace<Valley>(Key('x', 0));
  Estimate initial;
  initial.values.insert(Key('x', 0), Vector2d(-1.2, 1.0));
  for (int iterations : {1, 2, 3, 100}) {
    AlternatingOptions options;
    options.continuous_iterations = iterations;
    const AlternatingResult result = alternate(graph, initial, options);
    EXPECT_EQ(result.report.status, SolverStatus::kConverged) << result.report.message;
    EXPECT_LT((result.estimate.values.at<Vector2d>(Key('x', 0)) - Vector2d(1, 1)).norm(), 1e-6);
    options.max_iterations = 1;
    if (iterations == 100) continue;
    EXPECT_EQ(alternate(graph, initial, options).report.status, SolverStatus::kIterationLimit);
  }
}

TEST(AlternatingConvergence, SaysWhatIsUnderConstrainedOrStalled) {
  HybridGraph free;
  free.emplace<BetweenSE2>(pose(0), pose(1), SE2(1, 0, 0), Noise::unit(3));
  Estimate initial;
  initial.values.insert(pose(0), SE2());
  initial.values.insert(pose(1), SE2(3, 2, 1));
  const AlternatingResult result = alternate(free, initial);
  EXPECT_EQ(result.report.status, SolverStatus::kUnderConstrained);
  EXPECT_NE(result.report.message.find("x1"), std::string::npos) << result.report.message;
  EXPECT_LT(result.report.cost, 1e-6);

  HybridGraph wrong;
  wrong.emplace<WrongJacobian>(Key('x', 0));
  wrong.emplace<Prior<Vector2d>>(Key('x', 0), Vector2d(0, 0), Noise::isotropic(2, 1e3));
  Estimate start;
  start.values.insert(Key('x', 0), Vector2d(0.0, 0.0));
  EXPECT_EQ(alternate(wrong, start).report.status, SolverStatus::kStalled);
}

}  // namespace
}  // namespace hybrid
