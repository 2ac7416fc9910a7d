// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, the hybrid mapping authors
#pragma once

#include <memory>
#include <random>
#include <string>
#include <vector>

#include "libhybrid/factors/between.h"
#include "libhybrid/factors/prior.h"
#include "libhybrid/hybrid/graph.h"
#include "libhybrid/hybrid/mixture.h"

namespace hybrid::testing {

struct SimulatedGraph {
  HybridGraph graph;
  Estimate initial;
  Values truth;
};

inline Key pose(int i) {
  return Key('x', i);
}

template <class Group, class Random>
Group random_motion(double sigma, Random& rng) {
  std::normal_distribution<double> normal(0.0, sigma);
  typename Group::Tangent v;
  for (int i = 0; i < Group::kDim; ++i) v[i] = normal(rng);
  return Group::exp(v);
}

template <class Group>
Group step_forward(double turn);
template <>
inline SE2 step_forward<SE2>(double turn) {
  return {1.0, 0.0, turn};
}
template <>
inline SE3 step_forward<SE3>(double turn) {
  return SE3::exp((SE3::Tangent() << 1.0, 0.0, 0.1, 0.0, 0.05, turn).finished());
}

/// A winding path of n poses with odometry, a prior on the first pose, and loops between random
/// pairs. The initial values chain the noisy odometry.
template <class Group, class Factor = Between<Group>>
SimulatedGraph simulate_loops(int n, int loops, double sigma, unsigned seed) {
  std::mt19937 rng(seed);
  SimulatedGraph s;
  const Noise noise = Noise::isotropic(Group::kDim, sigma);
  Group truth, start;
  s.graph.emplace<Prior<Group>>(pose(0), truth, noise);
  s.truth.insert(pose(0), truth);
  s.initial.values.insert(pose(0), start);
  for (int i = 1; i < n; ++i) {
    const Group motion = step_forward<Group>(i % 5 == 0 ? 1.3 : 0.02);
    const Group measured = motion * random_motion<Group>(sigma, rng);
    truth = truth * motion;
    start = start * measured;
    s.graph.emplace<Factor>(pose(i - 1), pose(i), measured, noise);
    s.truth.insert(pose(i), truth);
    s.initial.values.insert(pose(i), start);
  }
  std::uniform_int_distribution<int> any(0, n - 1);
  for (int k = 0; k < loops; ++k) {
    const int a = any(rng);
    const int b = any(rng);
    if (a == b) continue;
    const Group motion = s.truth.at<Group>(pose(a)).inverse() * s.truth.at<Group>(pose(b));
    s.graph.emplace<Factor>(pose(a), pose(b), motion * random_motion<Group>(sigma, rng), noise);
  }
  return s;
}

/// The same with loops that are outlier mixtures with switches d0, d1, ...; a share `wild` of them
/// is false. Discrete factors couple switches if `coupled`.
inline SimulatedGraph simulate_outliers(int n, int loops, double wild, bool coupled,
                                        unsigned seed) {
  SimulatedGraph s = simulate_loops<SE2, BetweenSE2>(n, 0, 0.05, seed);
  std::mt19937 rng(seed + 1);
  std::uniform_int_distribution<int> any(0, n - 1);
  std::uniform_real_distribution<double> unit(0.0, 1.0);
  const Noise noise = Noise::isotropic(3, 0.05);
  for (int k = 0; k < loops; ++k) {
    const int a = any(rng);
    const int b = (a + 1 + std::uniform_int_distribution<int>(0, n - 2)(rng)) % n;
    SE2 motion = s.truth.at<SE2>(pose(a)).inverse() * s.truth.at<SE2>(pose(b));
    motion = motion * random_motion<SE2>(unit(rng) < wild ? 2.0 : 0.05, rng);
    const DiscreteKey key{Key('d', k), 2};
    s.graph.add(make_outlier_mixture(
        key, std::make_shared<BetweenSE2>(pose(a), pose(b), motion, noise),
        std::make_shared<BetweenSE2>(pose(a), pose(b), motion, noise.inflated(1e4)), 0.7, 0.3));
    s.initial.assignment.set(key.key, k % 2);
    if (coupled && k > 0) {
      s.graph.add(transition_table({Key('d', k - 1), 2}, key, {0.8, 0.2, 0.3, 0.7}));
    }
  }
  return s;
}

/// Largest tangent difference between the variables of two sets of values.
inline double distance(const Values& a, const Values& b) {
  double largest = 0.0;
  for (Key key : a.keys()) {
    Eigen::VectorXd d(a.type(key).dim);
    local(a.type(key), a.data(key), b.data(key), d.data());
    largest = std::max(largest, d.cwiseAbs().maxCoeff());
  }
  return largest;
}

}  // namespace hybrid::testing
