// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, the hybrid mapping authors
#include "libhybrid/switching/autoregression.h"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>

#include "libhybrid/core/error.h"
#include "libhybrid/factors/expect_jacobians.h"
#include "libhybrid/factors/linear_motion.h"
#include "libhybrid/factors/prior.h"
#include "libhybrid/hybrid/mixture.h"
#include "libhybrid/smoother/incremental.h"
#include "libhybrid/solvers/alternating.h"
#include "libhybrid/solvers/exhaustive.h"
#include "tests/libhybrid/switching/switching_systems.h"

namespace hybrid {
namespace {

using testing::Random;
using testing::simulate;
using testing::two_modes;
using Vector1 = Eigen::Matrix<double, 1, 1>;

/// -log p(series, modes).
double joint_cost(const SwitchingModel& model, const Series& series,
                  const std::vector<int>& modes) {
  double sum = -std::log(model.chain.initial[modes[0]]);
  for (int t = 0; t < series.cols(); ++t) {
    if (t > 0) sum -= std::log(model.chain.transition(modes[t - 1], modes[t]));
    if (t < model.order) continue;
    const Autoregression& motion = model.motions[modes[t]];
    const Eigen::VectorXd e =
        series.col(t) - motion.coefficients * regressors(series, t, model.order);
    sum += 0.5 * (e.dot(motion.covariance.inverse() * e) +
                  std::log((2.0 * M_PI * motion.covariance).determinant()));
  }
  return sum;
}

TEST(Labelling, EqualsEnumeration) {
  Random random(4);
  const SwitchingModel model = two_modes(0.7);
  for (int trial = 0; trial < 5; ++trial) {
    const Series series = simulate(model, 9, random).series;
    const int n = static_cast<int>(series.cols());
    double best = std::numeric_limits<double>::infinity(), sum = 0.0;
    std::vector<int> best_modes;
    Eigen::MatrixXd probabilities = Eigen::MatrixXd::Zero(2, n);
    for (int code = 0; code < (1 << n); ++code) {
      std::vector<int> modes(n);
      for (int t = 0; t < n; ++t) modes[t] = (code >> t) & 1;
      const double cost = joint_cost(model, series, modes);
      if (cost < best) best = cost, best_modes = modes;
      sum += std::exp(-cost);
      for (int t = 0; t < n; ++t) probabilities(modes[t], t) += std::exp(-cost);
    }
    const Labelling found = label(model, series);
    EXPECT_EQ(found.modes, best_modes);
    EXPECT_NEAR(found.log_likelihood, std::log(sum), 1e-9);
    EXPECT_LT((found.probabilities - probabilities / sum).cwiseAbs().maxCoeff(), 1e-9);
  }
}

TEST(Labelling, FindsTheModesOfALongSeries) {
  Random random(5);
  const LabelledSeries truth = simulate(two_modes(), 2000, random);
  const Labelling found = label(two_modes(), truth.series);
  int right = 0;
  for (int t = 0; t < 2000; ++t) right += found.modes[t] == truth.modes[t];
  EXPECT_GT(right, 1960);
}

TEST(Labelling, RejectsWhatDoesNotFit) {
  EXPECT_THROW(label(two_modes(), Series::Zero(3, 10)), Error);
  EXPECT_THROW(label(two_modes(), Series::Zero(2, 0)), Error);
  Series series = Series::Zero(2, 10);
  series(1, 4) = std::numeric_limits<double>::infinity();
  EXPECT_THROW(label(two_modes(), series), Error);
  SwitchingModel model = two_modes();
  model.chain.transition(0, 0) += 0.01;
  EXPECT_THROW(label(model, Series::Zero(2, 10)), Error);
  model = two_modes();
  model.motions.pop_back();
  EXPECT_THROW(label(model, Series::Zero(2, 10)), Error);
}

TEST(LinearMotion, Jacobians) {
  Random random(6);
  for (int trial = 0; trial < 10; ++trial) {
    Values values;
    values.insert(Key('a', 0), random.value<Eigen::Vector3d>());
    values.insert(Key('a', 1), random.value<Eigen::Vector3d>());
    Eigen::Matrix3d F;
    for (double& entry : F.reshaped()) entry = random.normal();
    testing::expect_jacobians(
        LinearMotion<3>(Key('a', 0), Key('a', 1), F, random.vector<3>(), random.noise(3)), values);
  }
}

/// A point that rests or drifts, measured with noise: states are unknown as well as modes.
struct HiddenMotion {
  HybridGraph graph;
  Estimate initial;
  std::vector<Delta> steps;

  explicit HiddenMotion(int n, Random& random) {
    double x = 0.0;
    const MarkovChain chain = sticky_chain(2, 0.8);
    for (int t = 0; t < n; ++t) {
      const bool drifts = t >= n / 3 && t < 2 * n / 3;
      if (t > 0) x += drifts ? 1.0 : 0.0;
      Delta delta;
      const Vector1 z(x + random.normal(0.1));
      delta.values.insert(Key('x', t), z);
      delta.continuous.push_back(
          std::make_shared<Prior<Vector1>>(Key('x', t), z, Noise::isotropic(1, 0.1)));
      if (t > 0) {
        const auto motion = [&](double step) {
          return std::make_shared<LinearMotion<1>>(Key('x', t - 1), Key('x', t), Vector1(1.0),
                                                   Vector1(step), Noise::isotropic(1, 0.05));
        };
        delta.hybrid.push_back(
            std::make_shared<Mixture>(std::vector<DiscreteKey>{mode_key(t, 2)},
                                      std::vector<MixtureComponent>{{motion(0.0)}, {motion(1.0)}}));
        if (t == 1) delta.discrete.push_back(chain_tables(chain, {mode_key(1, 2)})[0]);
        if (t > 1) delta.discrete.push_back(chain_step(chain, mode_key(t - 1, 2), mode_key(t, 2)));
        initial.assignment.set(mode_key(t, 2).key, 0);
      }
      initial.values.insert(Key('x', t), z);
      for (const auto& factor : delta.continuous) graph.add(factor);
      for (const auto& factor : delta.hybrid) graph.add(factor);
      for (const auto& table : delta.discrete) graph.add(table);
      steps.push_back(std::move(delta));
    }
  }
};

TEST(SwitchingSystem, AlternationAndSmootherFindTheExhaustiveOptimum) {
  Random random(7);
  for (int trial = 0; trial < 5; ++trial) {
    const HiddenMotion system(9, random);
    const ExhaustiveResult best = solve_exhaustive(system.graph, system.initial.values);
    const AlternatingResult found = alternate(system.graph, system.initial);
    EXPECT_NEAR(found.report.objective, best.objective, 1e-6);
    IncrementalSmoother smoother;
    for (const Delta& delta : system.steps) smoother.update(delta);
    smoother.converge();
    EXPECT_NEAR(smoother.objective(), best.objective, 1e-6);
    EXPECT_EQ(smoother.assignment(), best.estimate.assignment);
  }
}

}  // namespace
}  // namespace hybrid
