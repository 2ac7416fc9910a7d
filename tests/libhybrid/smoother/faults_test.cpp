// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, the hybrid mapping authors
// What goes wrong in other incremental hybrid smoothers: stale linearisation after a flip, growing
// memory, deep recursion, cost of untouched variables, trees thickened by false closures.
#include <gtest/gtest.h>

#include <cmath>
#include <memory>

#include "libhybrid/smoother/incremental.h"
#include "libhybrid/solvers/levenberg_marquardt.h"
#include "tests/support/random.h"
#include "tests/support/simulated_graphs.h"

namespace hybrid {
namespace {

using testing::distance;
using testing::pose;
using testing::Random;

ContinuousFactorPtr between(int i, int j, const SE2& z, double sigma = 0.05) {
  return std::make_shared<BetweenSE2>(pose(i), pose(j), z, Noise::isotropic(3, sigma));
}

DiscreteKey binary(int i) {
  return {Key('d', static_cast<std::uint64_t>(i)), 2};
}

HybridFactorPtr closure(int number, int i, int j, const SE2& z) {
  return make_outlier_mixture(binary(number), between(i, j, z),
                              between(i, j, z, 0.05 * std::sqrt(1e7)), 0.5, 0.5);
}

/// A path of n poses with a prior on the first.
Delta path(int n, const SE2& motion) {
  Delta delta;
  SE2 x;
  delta.values.insert(pose(0), x);
  delta.continuous.push_back(std::make_shared<Prior<SE2>>(pose(0), x, Noise::isotropic(3, 0.01)));
  for (int i = 1; i < n; ++i) {
    x = x * motion;
    delta.values.insert(pose(i), x);
    delta.continuous.push_back(between(i - 1, i, motion));
  }
  return delta;
}

Values batch(const IncrementalSmoother& smoother) {
  SolverOptions options;
  options.relative_decrease = 1e-15;
  return levenberg_marquardt(smoother.graph(), smoother.estimate(), options).values;
}

TEST(Faults, AFlipTakesANewLinearisation) {
  constexpr int kPoses = 60;
  IncrementalSmoother smoother;
  Delta delta = path(kPoses, SE2(1.0, 0.0, 0.1));
  const SE2 z = SE2(1.0, 0.0, 0.0);
  delta.hybrid.push_back(std::make_shared<Mixture>(
      std::vector<DiscreteKey>{binary(0)},
      std::vector<MixtureComponent>{{between(0, kPoses - 1, z * SE2(0.0, 0.5, 0.2)), 0.0, false},
                                    {between(0, kPoses - 1, z), 0.0, false}}));
  delta.discrete.push_back(Table({binary(0)}, {0.0, 1e4}));
  ASSERT_EQ(smoother.update(delta).status, UpdateReport::Status::kOk);
  smoother.converge(100, 1e-15);
  ASSERT_EQ(smoother.assignment().at(binary(0).key), 0);
  const SE2 in_mode_0 = smoother.values().at<SE2>(pose(kPoses - 1));

  Delta evidence;
  evidence.discrete.push_back(Table({binary(0)}, {2e4, 0.0}));
  const UpdateReport report = smoother.update(evidence);
  EXPECT_EQ(report.flips, 1);
  EXPECT_EQ(smoother.assignment().at(binary(0).key), 1);
  EXPECT_GT((in_mode_0.inverse() * smoother.values().at<SE2>(pose(kPoses - 1))).log().norm(), 0.3);
  for (int k = 0; k < 3; ++k) smoother.update({});  // no new evidence, only fluid relinearisation
  EXPECT_LT(distance(batch(smoother), smoother.values()), 0.05);
  smoother.converge(100, 1e-15);
  EXPECT_LT(distance(batch(smoother), smoother.values()), 1e-6);
}

TEST(Faults, MemoryStaysBoundedWhenTheSameFactorsComeAndGo) {
  IncrementalSmoother smoother;
  smoother.update(path(20, SE2(1.0, 0.0, 0.3)));
  std::size_t bytes = 0;
  for (int k = 0; k < 10000; ++k) {
    Delta add;
    add.continuous.push_back(between(3, 15, SE2(0.1 * (k % 7), 1.0, 0.2)));
    add.hybrid.push_back(closure(k, 2, 18, SE2(k % 2, 1.0, 0.2)));
    Delta remove;
    remove.remove = smoother.update(add).handles.all();
    ASSERT_EQ(remove.remove.size(), 2u);
    smoother.update(remove);
    if (k == 100) bytes = smoother.memory().bytes;
  }
  EXPECT_LE(smoother.memory().bytes, bytes + bytes / 20);
  EXPECT_EQ(smoother.assignment().size(), 0u);
  EXPECT_EQ(smoother.graph().size(), 20u);
  smoother.converge();
  EXPECT_NEAR(smoother.cost(), 0.0, 1e-9);
}

/// A measured difference of two numbers.
class Difference : public FactorOf<1, Eigen::Matrix<double, 1, 1>, Eigen::Matrix<double, 1, 1>> {
 public:
  using Number = Eigen::Matrix<double, 1, 1>;
  Difference(Key a, Key b) : FactorOf({a, b}, Noise::isotropic(1, 1.0), {}) {}
  std::string name() const override { return "difference"; }
  Residual evaluate(const Number& a, const Number& b, Jacobian<Number>* Ja,
                    Jacobian<Number>* Jb) const override {
    if (Ja != nullptr) *Ja = -Number::Ones();
    if (Jb != nullptr) *Jb = Number::Ones();
    return b - a - Number::Ones();
  }
};

TEST(Faults, AChainOfAMillionVariablesNeedsNoDeepStack) {
  using Number = Difference::Number;
  constexpr int kCount = 1000000;
  IncrementalSmoother smoother;
  for (int begin = 0; begin < kCount; begin += kCount / 4) {
    Delta delta;
    for (int i = begin; i < begin + kCount / 4; ++i) {
      delta.values.insert(Key('n', i), Number(Number::Zero()));
      if (i == 0) {
        delta.continuous.push_back(std::make_shared<Prior<Number>>(
            Key('n', 0), Number(Number::Zero()), Noise::isotropic(1, 1.0)));
      } else {
        delta.continuous.push_back(std::make_shared<Difference>(Key('n', i - 1), Key('n', i)));
      }
    }
    ASSERT_EQ(smoother.update(delta).status, UpdateReport::Status::kOk);
  }
  const Key last('n', kCount - 1);
  EXPECT_NEAR(smoother.values().at<Number>(last)[0], kCount - 1.0, 10.0);  // of a deviation of 1000
  EXPECT_NEAR(smoother.joint_covariance({last})(0, 0), kCount, 1e-6 * kCount);
}

TEST(Faults, AnUpdateDoesNotDependOnUntouchedDiscreteVariables) {
  UpdateReport reports[2];
  for (int many = 0; many < 2; ++many) {
    const SE2 motion(1.0, 0.0, 0.1);
    IncrementalSmoother smoother;
    smoother.update(path(100, motion));
    Delta delta;
    for (int k = 0; k < (many != 0 ? 2000 : 10); ++k) {
      const int i = k % 10;
      delta.hybrid.push_back(closure(k, i, i + 1, k % 2 == 0 ? motion : SE2(9.0, 0.0, 0.0)));
    }
    smoother.update(delta);
    Delta next;
    next.values.insert(pose(100), smoother.values().at<SE2>(pose(99)) * motion);
    next.continuous.push_back(between(99, 100, motion));
    next.hybrid.push_back(closure(5000, 95, 100, SE2(9.0, 0.0, 0.0)));
    reports[many] = smoother.update(next);
  }
  EXPECT_EQ(reports[1].components, reports[0].components);
  EXPECT_EQ(reports[0].components, 1);
  EXPECT_EQ(reports[1].eliminated, reports[0].eliminated);
  EXPECT_EQ(reports[1].relinearized, reports[0].relinearized);
  EXPECT_EQ(reports[1].flips, 1);
}

/// Fill of the tree of a path that grew one pose at a time, with false closures or without.
std::size_t fill(bool closures, int initial_value) {
  Random random(7);
  const SE2 motion(1.0, 0.0, 0.1);
  IncrementalSmoother smoother;
  smoother.update(path(1, motion));
  for (int i = 1; i < 300; ++i) {
    Delta delta;
    delta.values.insert(pose(i), smoother.values().at<SE2>(pose(i - 1)) * motion);
    delta.continuous.push_back(between(i - 1, i, motion));
    const SE2 z(random.uniform(60.0, 90.0), 5.0, random.uniform(-3.0, 3.0));
    const int old = random.below(i);
    if (closures && old < i - 2) {
      delta.hybrid.push_back(closure(i, old, i, z));
      delta.assignment.set(binary(i).key, initial_value);
    }
    smoother.update(delta);
  }
  for (const auto& [key, value] : smoother.assignment()) EXPECT_EQ(value, 1) << key;
  return smoother.tree().cliques().factor_size();
}

TEST(Faults, RejectedClosuresDoNotThickenTheTree) {
  const std::size_t without = fill(false, 1);
  EXPECT_EQ(fill(true, 1), without);
  EXPECT_EQ(fill(true, 0), without);
}

}  // namespace
}  // namespace hybrid
