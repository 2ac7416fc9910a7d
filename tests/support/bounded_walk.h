// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, the hybrid mapping authors
#pragma once

#include <algorithm>
#include <memory>
#include <set>
#include <vector>

#include "libhybrid/factors/linear_factor.h"
#include "libhybrid/factors/prior.h"
#include "libhybrid/smoother/window.h"
#include "tests/support/random.h"

namespace hybrid::testing {

inline WindowOptions bounded(int complete, int sightings, int tied = 1000) {
  WindowOptions options;
  options.mode = WindowOptions::Mode::kBounded;
  options.complete = complete;
  options.sightings = sightings;
  options.tied = tied;
  return options;
}

inline WindowOptions of_vectors(WindowOptions options) {
  options.states = "x";
  return options;
}

inline std::size_t count_poses(const Values& values) {
  const std::vector<Key> keys = values.keys();
  return static_cast<std::size_t>(
      std::count_if(keys.begin(), keys.end(), [](Key key) { return key.letter() == 'x'; }));
}

/// A linear world: states that walk in a circle and see the landmarks near them, three at a time
/// and each for twelve steps.
class LinearWalk {
 public:
  explicit LinearWalk(std::uint64_t seed, int landmarks) : random_(seed), landmarks_(landmarks) {}

  Delta step() {
    Delta delta;
    const Key now('x', static_cast<std::uint64_t>(t_));
    delta.values.insert(now, Vector2d(0.0, 0.0));
    if (t_ == 0) {
      delta.continuous.push_back(
          std::make_shared<Prior<Vector2d>>(now, Vector2d(0.0, 0.0), Noise::isotropic(2, 0.1)));
    } else {
      delta.continuous.push_back(
          difference(Key('x', static_cast<std::uint64_t>(t_ - 1)), now, noise(0.3), 0.3));
    }
    for (int k = 0; k < 3; ++k) {
      const Key landmark('l', static_cast<std::uint64_t>((t_ / 4 + k) % landmarks_));
      if (seen_.insert(landmark).second) delta.values.insert(landmark, Vector2d(0.0, 0.0));
      delta.continuous.push_back(difference(now, landmark, noise(0.5), 0.5));
    }
    ++t_;
    return delta;
  }

  /// Several steps as one change.
  Delta steps(int count) {
    Delta all;
    for (int i = 0; i < count; ++i) {
      const Delta one = step();
      all.continuous.insert(all.continuous.end(), one.continuous.begin(), one.continuous.end());
      for (Key key : one.values.keys()) {
        all.values.insert(key, one.values.type(key), one.values.data(key));
      }
    }
    return all;
  }

 private:
  using Vector2d = Eigen::Vector2d;

  static ContinuousFactorPtr difference(Key a, Key b, const Vector2d& z, double sigma) {
    return std::make_shared<LinearFactor>(
        std::vector<LinearFactor::Term>{{a, -Eigen::Matrix2d::Identity()},
                                        {b, Eigen::Matrix2d::Identity()}},
        z, Noise::isotropic(2, sigma));
  }
  Vector2d noise(double sigma) { return {random_.normal(sigma), random_.normal(sigma)}; }

  testing::Random random_;
  int landmarks_, t_ = 0;
  std::set<Key> seen_;
};

}  // namespace hybrid::testing
