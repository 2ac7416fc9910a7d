// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, the hybrid mapping authors
#include "libhybrid/marginals/evidence.h"

#include <gtest/gtest.h>

#include <Eigen/LU>
#include <cmath>

#include "libhybrid/factors/bearing_range.h"
#include "libhybrid/factors/linear_motion.h"
#include "libhybrid/solvers/levenberg_marquardt.h"
#include "tests/support/dense_graph.h"
#include "tests/support/random.h"
#include "tests/support/simulated_graphs.h"

namespace hybrid {
namespace {

using testing::Random;
using Vector1 = Eigen::Matrix<double, 1, 1>;

constexpr double kLog2Pi = 1.8378770664093454836;
const Key kA('x', 0), kB('x', 1);
const DiscreteKey kMode{Key('m', 0), 2};

/// log of the integral of exp(-L) over one or two scalars, by the trapezoidal rule, which for
/// smooth densities that vanish at the ends is as exact as its points are many.
double quadrature(const HybridGraph& graph, Estimate at, const std::vector<Key>& keys, double half,
                  int points) {
  const double least = objective(graph, at.values, at.assignment);
  const Estimate centre = at;
  const double step = 2.0 * half / points;
  double sum = 0.0;
  for (int i = 0; i <= points; ++i) {
    for (int j = 0; j <= (keys.size() == 2 ? points : 0); ++j) {
      at.values.update(keys[0], Vector1(centre.values.at<Vector1>(keys[0])[0] - half + i * step));
      if (keys.size() == 2) {
        at.values.update(keys[1], Vector1(centre.values.at<Vector1>(keys[1])[0] - half + j * step));
      }
      sum += std::exp(least - objective(graph, at.values, at.assignment));
    }
  }
  return -least + std::log(sum) + static_cast<double>(keys.size()) * std::log(step);
}

ContinuousFactorPtr prior(Key key, double z, double sigma) {
  return std::make_shared<Prior<Vector1>>(key, Vector1(z), Noise::isotropic(1, sigma));
}

ContinuousFactorPtr motion(Key a, Key b, double z, double sigma) {
  return std::make_shared<LinearMotion<1>>(a, b, Vector1(1.0), Vector1(z),
                                           Noise::isotropic(1, sigma));
}

Estimate solved(const HybridGraph& graph, Estimate estimate) {
  SolverOptions options;
  options.relative_decrease = 1e-15;
  estimate.values = levenberg_marquardt(graph, estimate, options).values;
  return estimate;
}

Estimate two_scalars(double a, double b) {
  Estimate estimate;
  estimate.values.insert(kA, Vector1(a));
  estimate.values.insert(kB, Vector1(b));
  return estimate;
}

TEST(Evidence, OfOneScalarIsTheDensityOfWhatWasMeasured) {
  HybridGraph graph;
  graph.add(prior(kA, 1.0, 0.7));
  graph.add(prior(kA, 2.5, 1.2));
  Estimate estimate;
  estimate.values.insert(kA, Vector1(0.0));
  estimate = solved(graph, estimate);
  const double variance = 0.7 * 0.7 + 1.2 * 1.2;
  const double expected = -0.5 * (1.5 * 1.5 / variance + std::log(variance) + kLog2Pi);
  EXPECT_NEAR(*log_evidence(graph, estimate).log, expected, 1e-12);
  EXPECT_NEAR(quadrature(graph, estimate, {kA}, 10.0, 1000), expected, 1e-12);
}

TEST(Evidence, OfTwoScalarsEqualsTheIntegral) {
  HybridGraph graph;
  graph.add(prior(kA, 0.3, 0.5));
  graph.add(motion(kA, kB, 1.0, 0.4));
  graph.add(prior(kB, 2.0, 0.8));
  graph.add(prior_table(kMode, {0.25, 0.75}));
  Estimate estimate = two_scalars(0.0, 0.0);
  estimate.assignment.set(kMode.key, 1);
  estimate = solved(graph, estimate);
  EXPECT_NEAR(*log_evidence(graph, estimate).log, quadrature(graph, estimate, {kA, kB}, 6.0, 600),
              1e-10);
}

/// A range from the origin of the plane to a point that another measurement holds on a line.
class Distance : public FactorOf<1, Vector1, Vector1> {
 public:
  Distance(double z, double sigma) : FactorOf({kA, kB}, Noise::isotropic(1, sigma)), z_(z) {}
  std::string name() const override { return "distance"; }
  Residual evaluate(const Vector1& a, const Vector1& b, Jacobian<Vector1>* Ja,
                    Jacobian<Vector1>* Jb) const override {
    const double d = std::hypot(a[0], b[0]);
    if (Ja != nullptr) (*Ja)(0) = a[0] / d;
    if (Jb != nullptr) (*Jb)(0) = b[0] / d;
    return Residual(d - z_);
  }

 private:
  double z_;
};

// Of a curved residual the Hessian J'J misses what the residual itself bends it by. Here the
// residual at the optimum is 0.16 sigmas, the curvature across 1 / 5 and the information there 1 /
// (4 sigma^2): a share of 0.128 sigma, of which the log of the root is half; the rest falls with
// sigma^2.
TEST(Evidence, ApproachesTheIntegralOfACurvedResidualAsNoiseShrinks) {
  for (const double sigma : {0.4, 0.2, 0.1, 0.05}) {
    HybridGraph graph;
    graph.emplace<Distance>(5.0, sigma);
    graph.add(prior(kA, 3.0, 2.0 * sigma));
    graph.add(prior(kB, 4.0 + sigma, 2.0 * sigma));
    const Estimate estimate = solved(graph, two_scalars(3.0, 4.0));
    const double exact = quadrature(graph, estimate, {kA, kB}, 12.0 * sigma, 600);
    const double error = std::abs(*log_evidence(graph, estimate).log - exact);
    EXPECT_NEAR(error, 0.064 * sigma, 0.03 * sigma * sigma);
  }
}

TEST(Evidence, EqualsTheDenseDeterminantOnRandomHybridGraphs) {
  for (unsigned seed = 1; seed <= 20; ++seed) {
    const auto s = testing::simulate_outliers(15, 10, 0.4, seed % 2 == 0, seed);
    const Estimate estimate = solved(s.graph, s.initial);
    const Eigen::MatrixXd information = testing::dense_information(s.graph, estimate);
    const double expected =
        -objective(s.graph, estimate.values, estimate.assignment) +
        0.5 * (information.rows() * kLog2Pi - testing::log_determinant(information));
    EXPECT_NEAR(*log_evidence(s.graph, estimate).log, expected, 1e-7);
  }
}

// Leaves of a large graph are eliminated by Schur complement; their pivots count too.
TEST(Evidence, CountsVariablesEliminatedBySchurComplement) {
  HybridGraph graph;
  Estimate estimate;
  Random random(3);
  for (int i = 0; i < 4; ++i) {
    estimate.values.insert(testing::pose(i), SE2(i, 0, 0));
    graph.emplace<Prior<SE2>>(testing::pose(i), SE2(i, 0, 0), Noise::isotropic(3, 0.1));
  }
  for (int l = 0; l < 400; ++l) {
    const Key point('l', l);
    const Eigen::Vector2d at(random.uniform(0, 5), random.uniform(2, 6));
    estimate.values.insert(point, at);
    for (int i = 0; i < 4; ++i) {
      const Eigen::Vector2d seen = estimate.values.at<SE2>(testing::pose(i)).inverse() * at;
      graph.emplace<BearingRange2>(testing::pose(i), point,
                                   Eigen::Vector2d(seen.norm(), std::atan2(seen[1], seen[0])),
                                   Noise::isotropic(2, 0.2));
    }
  }
  const Eigen::MatrixXd information = testing::dense_information(graph, estimate);
  const double expected =
      -objective(graph, estimate.values, {}) +
      0.5 * (information.rows() * kLog2Pi - testing::log_determinant(information));
  EXPECT_NEAR(*log_evidence(graph, estimate).log, expected, 1e-6);
}

HybridFactorPtr jump(ContinuousFactorPtr first, ContinuousFactorPtr second, double constant) {
  return std::make_shared<Mixture>(
      std::vector<DiscreteKey>{kMode},
      std::vector<MixtureComponent>{{std::move(first), 0.2}, {std::move(second), constant}});
}

// A component of other dimension, or none, changes the evidence by the density of its measurement.
TEST(Evidence, ComparesComponentsOfOtherDimensionsAndNone) {
  HybridGraph graph;
  graph.add(prior(kA, 0.0, 1.0));
  graph.add(motion(kA, kB, 1.0, 0.5));
  graph.add(jump(prior(kB, 3.0, 0.6), nullptr, 1.7));
  Estimate with = two_scalars(0, 0);
  with.assignment.set(kMode.key, 0);
  Estimate without = with;
  without.assignment.set(kMode.key, 1);
  const double variance = 1.0 + 0.25 + 0.36;
  const double density = -0.5 * (4.0 / variance + std::log(variance) + kLog2Pi);
  EXPECT_NEAR(*log_evidence(graph, solved(graph, with)).log, density - 0.2, 1e-12);
  EXPECT_NEAR(*log_evidence(graph, solved(graph, without)).log, -1.7, 1e-12);
}

TEST(Evidence, HasNoNumberWhereVariablesAreUndetermined) {
  HybridGraph graph;
  graph.add(prior(kA, 0.0, 1.0));
  graph.add(jump(motion(kA, kB, 1.0, 0.5), nullptr, 0.0));
  Estimate estimate = two_scalars(0, 1);
  estimate.assignment.set(kMode.key, 0);
  EXPECT_TRUE(log_evidence(graph, estimate).log.has_value());
  estimate.assignment.set(kMode.key, 1);
  const Evidence evidence = log_evidence(graph, estimate);
  EXPECT_FALSE(evidence.log.has_value());
  EXPECT_EQ(evidence.under_constrained, std::vector<Key>{kB});
}

TEST(Evidence, OfAnImpossibleAssignmentIsMinusInfinity) {
  HybridGraph graph;
  graph.add(prior(kA, 0.0, 1.0));
  graph.add(Table({kMode}, {0.0, INFINITY}));
  Estimate estimate;
  estimate.values.insert(kA, Vector1(0.0));
  estimate.assignment.set(kMode.key, 1);
  EXPECT_EQ(*log_evidence(graph, estimate).log, -INFINITY);
}

}  // namespace
}  // namespace hybrid
