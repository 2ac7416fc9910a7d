// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, the hybrid mapping authors
#pragma once

#include <algorithm>
#include <cmath>
#include <memory>
#include <vector>

#include "libhybrid/factors/bearing_range.h"
#include "libhybrid/factors/between.h"
#include "libhybrid/factors/prior.h"
#include "libhybrid/factors/range.h"
#include "libhybrid/hybrid/mixture.h"
#include "libhybrid/smoother/incremental.h"
#include "libhybrid/switching/markov.h"
#include "tests/support/random.h"

namespace hybrid::bench {

/// A world drawn from the model that it is estimated with, one change per keyframe.
struct DiscreteWorld {
  std::vector<Delta> steps;
  std::vector<DiscreteKey> keys;  ///< binary, in order of time
  std::vector<int> truth;         ///< their values
  Values poses;                   ///< true poses
};

/// A range with noise, drawn again until it is not negative, as sensors give no negative ranges.
inline double measured_range(double truth, double sigma, testing::Random& random) {
  double z = -1.0;
  while (z < 0.0) z = truth + random.normal(sigma);
  return z;
}

/// A motion with noise (sigmas over x, y and angle).
inline SE2 disturbed(const SE2& motion, const Eigen::Vector3d& sigmas, testing::Random& random) {
  return {motion.x() + random.normal(sigmas[0]), motion.y() + random.normal(sigmas[1]),
          motion.angle() + random.normal(sigmas[2])};
}

/// Adds a pose to the world, with its initial estimate.
inline Delta& add_pose(DiscreteWorld& world, const SE2& truth, const SE2& estimate) {
  const Key key('x', world.steps.size());
  world.steps.emplace_back();
  world.steps.back().values.insert(key, estimate);
  world.poses.insert(key, truth);
  if (world.steps.size() == 1) {
    world.steps.back().continuous.push_back(
        std::make_shared<Prior<SE2>>(key, truth, Noise::isotropic(3, 0.01)));
  }
  return world.steps.back();
}

inline SE2 command(int i) {
  return {0.5, 0.0, i % 12 < 3 ? 0.35 : 0.02};
}

/// Wheels that slip at times: in mode 1, about half of the commanded motion is real. Landmarks are
/// sometimes seen by range and bearing.
inline DiscreteWorld slip_world(int poses, int seed) {
  testing::Random random(seed);
  const Eigen::Vector3d grip(0.02, 0.02, 0.01), slip(0.15, 0.04, 0.03);
  const MarkovChain chain{Eigen::Vector2d(0.9, 0.1),
                          (Eigen::Matrix2d() << 0.92, 0.08, 0.3, 0.7).finished()};
  const Noise sighting = Noise::diagonal(Eigen::Vector2d(0.15, 0.03));
  std::vector<Eigen::Vector2d> landmarks;
  for (int l = 0; l < 12; ++l) landmarks.emplace_back(random.uniform(-3, 9), random.uniform(-3, 9));
  DiscreteWorld world;
  std::vector<bool> seen(landmarks.size(), false);
  SE2 truth, estimate;
  add_pose(world, truth, estimate);
  for (int i = 1; i < poses; ++i) {
    const DiscreteKey mode{Key('m', i), 2};
    const int before = world.truth.empty() ? 0 : world.truth.back();
    const double p = world.truth.empty() ? chain.initial[1] : chain.transition(before, 1);
    world.truth.push_back(random.uniform() < p ? 1 : 0);
    const SE2 u = command(i), half(0.5 * u.x(), 0.5 * u.y(), 0.5 * u.angle());
    truth = truth *
            (world.truth.back() == 0 ? disturbed(u, grip, random) : disturbed(half, slip, random));
    estimate = estimate * u;
    Delta& delta = add_pose(world, truth, estimate);
    const Key from('x', i - 1), to('x', i);
    delta.hybrid.push_back(std::make_shared<Mixture>(
        std::vector<DiscreteKey>{mode},
        std::vector<MixtureComponent>{
            {std::make_shared<BetweenSE2>(from, to, u, Noise::diagonal(grip))},
            {std::make_shared<BetweenSE2>(from, to, half, Noise::diagonal(slip))}}));
    delta.discrete.push_back(world.keys.empty() ? chain_tables(chain, {mode}).front()
                                                : chain_step(chain, world.keys.back(), mode));
    world.keys.push_back(mode);
    for (std::size_t l = 0; l < landmarks.size(); ++l) {
      const Eigen::Vector2d local = truth.inverse() * landmarks[l];
      if (local.norm() > 5.0 || random.uniform() < 0.5) continue;
      const Eigen::Vector2d z(measured_range(local.norm(), 0.15, random),
                              std::atan2(local[1], local[0]) + random.normal(0.03));
      if (!seen[l]) delta.values.insert(Key('l', l), Eigen::Vector2d(estimate * from_polar(z)));
      seen[l] = true;
      delta.continuous.push_back(std::make_shared<BearingRange2>(to, Key('l', l), z, sighting));
    }
  }
  return world;
}

/// Loop closures, two in five of them outliers drawn from their wide Gaussian.
inline DiscreteWorld closure_world(int poses, int seed) {
  testing::Random random(seed);
  const Eigen::Vector3d odometry(0.03, 0.03, 0.02), closure(0.05, 0.05, 0.02);
  const double widening = 15.0, inlier_weight = 0.6;
  DiscreteWorld world;
  SE2 truth, estimate;
  add_pose(world, truth, estimate);
  for (int i = 1; i < poses; ++i) {
    const SE2 u = command(i);
    truth = truth * u;
    const SE2 measured = disturbed(u, odometry, random);
    estimate = estimate * measured;
    Delta& delta = add_pose(world, truth, estimate);
    const Key to('x', i);
    delta.continuous.push_back(
        std::make_shared<BetweenSE2>(Key('x', i - 1), to, measured, Noise::diagonal(odometry)));
    if (i < 8 || random.uniform() < 0.5) continue;
    const Key from('x', random.below(i - 5));
    const DiscreteKey key{Key('d', i), 2};
    world.truth.push_back(random.uniform() < inlier_weight ? 0 : 1);
    const double factor = world.truth.back() == 0 ? 1.0 : widening;
    const SE2 z = disturbed(world.poses.at<SE2>(from).between(truth), factor * closure, random);
    delta.hybrid.push_back(make_outlier_mixture(
        key, std::make_shared<BetweenSE2>(from, to, z, Noise::diagonal(closure)),
        std::make_shared<BetweenSE2>(from, to, z, Noise::diagonal(widening * closure)),
        inlier_weight, 1.0 - inlier_weight));
    world.keys.push_back(key);
  }
  return world;
}

/// Ranges to four known anchors; those out of line of sight are longer and noisier.
inline DiscreteWorld range_world(int poses, int seed) {
  testing::Random random(seed);
  const Eigen::Vector3d odometry(0.05, 0.05, 0.03);
  const double bias[2] = {0.0, 0.4}, sigma[2] = {0.08, 0.3};
  const MarkovChain chain{Eigen::Vector2d(0.7, 0.3),
                          (Eigen::Matrix2d() << 0.85, 0.15, 0.3, 0.7).finished()};
  const Eigen::Vector2d anchors[] = {{-4, -4}, {10, -4}, {-4, 10}, {10, 10}};
  DiscreteWorld world;
  SE2 truth, estimate;
  Delta& start = add_pose(world, truth, estimate);
  for (int a = 0; a < 4; ++a) {
    start.values.insert(Key('a', a), anchors[a]);
    start.continuous.push_back(std::make_shared<Prior<Eigen::Vector2d>>(Key('a', a), anchors[a],
                                                                        Noise::isotropic(2, 0.01)));
  }
  std::vector<int> last(4, -1);
  for (int i = 1; i < poses; ++i) {
    const SE2 u = command(i);
    truth = truth * u;
    const SE2 measured = disturbed(u, odometry, random);
    estimate = estimate * measured;
    Delta& delta = add_pose(world, truth, estimate);
    const Key to('x', i);
    delta.continuous.push_back(
        std::make_shared<BetweenSE2>(Key('x', i - 1), to, measured, Noise::diagonal(odometry)));
    const int a = i % 4;
    const DiscreteKey mode{Key('m', world.keys.size()), 2};
    const double p = last[a] < 0 ? chain.initial[1] : chain.transition(world.truth[last[a]], 1);
    const int m = random.uniform() < p ? 1 : 0;
    const double z = (truth.translation() - anchors[a]).norm() + bias[m] + random.normal(sigma[m]);
    std::vector<MixtureComponent> components;
    for (int k = 0; k < 2; ++k) {
      components.push_back({std::make_shared<Range<SE2, Eigen::Vector2d>>(
          to, Key('a', a), z - bias[k], Noise::isotropic(1, sigma[k]))});
    }
    delta.hybrid.push_back(
        std::make_shared<Mixture>(std::vector<DiscreteKey>{mode}, std::move(components)));
    delta.discrete.push_back(last[a] < 0 ? chain_tables(chain, {mode}).front()
                                         : chain_step(chain, world.keys[last[a]], mode));
    last[a] = static_cast<int>(world.keys.size());
    world.keys.push_back(mode);
    world.truth.push_back(m);
  }
  return world;
}

}  // namespace hybrid::bench
