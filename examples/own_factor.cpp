// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, the hybrid mapping authors

// A factor of your own on several variables: two robots measure the range between them by radio,
// too long by a bias that nobody knows. Graph, solution, covariances.
#include <algorithm>
#include <array>
#include <cmath>
#include <iostream>
#include <random>
#include <string>

#include "libhybrid/hybrid.h"

// [example]
using Bias = Eigen::Matrix<double, 1, 1>;  // a vector of one number [m]

/// The range between two robots, measured with a bias: residual |b - a| + bias - z [m].
class BiasedRange : public hybrid::FactorOf<1, hybrid::SE2, hybrid::SE2, Bias> {
 public:
  BiasedRange(hybrid::Key a, hybrid::Key b, hybrid::Key bias, double measured,
              const hybrid::Noise& noise, hybrid::Loss loss = {})
      : FactorOf({a, b, bias}, noise, loss), measured_(measured) {}

  std::string name() const override { return "biased range"; }

  Residual evaluate(const hybrid::SE2& a, const hybrid::SE2& b, const Bias& bias,
                    Jacobian<hybrid::SE2>* J_a, Jacobian<hybrid::SE2>* J_b,
                    Jacobian<Bias>* J_bias) const override {
    const Eigen::Vector2d way = b.translation() - a.translation();
    const double range = way.norm();
    if (J_a != nullptr) {  // all of them, or none
      // Robots in one place have no direction between them: a zero is a finite number.
      const Eigen::Vector2d to_b = way / std::max(range, 1e-9);
      *J_a << -to_b.transpose() * a.rotation().matrix(), 0;
      *J_b << to_b.transpose() * b.rotation().matrix(), 0;
      *J_bias << 1;
    }
    return Residual(range + bias[0] - measured_);
  }

 private:
  double measured_;
};
// [example]

int main() {
  using namespace hybrid;
  std::mt19937 random(7);
  const auto noisy = [&](double sigma) {
    return sigma * std::normal_distribution<double>()(random);
  };
  const Key bias('b', 0);
  const double true_bias = 0.8, sigma = 0.05;
  const Noise start = Noise::isotropic(3, 0.01);
  const Noise odometry = Noise::diagonal(Eigen::Vector3d(0.02, 0.02, 0.005));
  // The robots are r and s, what they drive in a step, and where they truly are.
  const std::array<char, 2> robots = {'r', 's'};
  const std::array<SE2, 2> motion = {SE2(0.5, 0, 0.05), SE2(0.4, 0, -0.03)};
  std::array<SE2, 2> truth = {SE2(0, 0, 0), SE2(0, 4, 0)};
  HybridGraph graph;
  Estimate initial;
  initial.values.insert(bias, Bias(0.0));
  for (std::uint64_t i = 0; i < 30; ++i) {
    for (int k : {0, 1}) {
      const Key pose(robots[k], i);
      if (i == 0) {
        graph.emplace<Prior<SE2>>(pose, truth[k], start);
        initial.values.insert(pose, truth[k]);
        continue;
      }
      truth[k] = truth[k] * motion[k];
      const Key before(robots[k], i - 1);
      const SE2 measured = motion[k] * SE2(noisy(0.02), noisy(0.02), noisy(0.005));
      graph.emplace<BetweenSE2>(before, pose, measured, odometry);
      initial.values.insert(pose, initial.values.at<SE2>(before) * measured);
    }
    const double range = (truth[1].translation() - truth[0].translation()).norm();
    graph.emplace<BiasedRange>(Key('r', i), Key('s', i), bias, range + true_bias + noisy(sigma),
                               Noise::isotropic(1, sigma));
  }
  const Estimate best = alternate(graph, initial).estimate;
  const ContinuousMarginals marginals(graph, best);
  const double found = best.values.at<Bias>(bias)[0];
  const double sure = std::sqrt(marginals.covariance(bias)(0, 0));
  std::cout << "the bias is " << found << " m, sigma " << sure << " m\n";
  // Rows and columns in the order of the keys: x, y, angle of the pose in its own axes, the bias.
  const Eigen::MatrixXd joint = marginals.joint_covariance({Key('r', 29), bias});
  std::cout << "covariance of the last pose of r and the bias:\n" << joint << '\n';
  return std::abs(found - true_bias) < 4 * sure && sure < sigma ? 0 : 1;
}
