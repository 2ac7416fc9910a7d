// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, the hybrid mapping authors
#pragma once

#include <cmath>
#include <random>
#include <vector>

#include "libhybrid/closures/problem.h"
#include "libhybrid/factors/between.h"
#include "libhybrid/factors/prior.h"
#include "tests/support/simulated_graphs.h"

namespace hybrid::testing {

struct CorruptedGraph {
  RobustProblem problem;
  std::vector<bool> truth;  ///< by closure: whether it is true
  Values poses;             ///< true poses
};

/// A robot that drives `laps` laps of twelve poses around a circle of radius 5 m, with odometry of
/// 1 cm and 0.3 degrees (twice that in 3-D), a true closure to each pose of the previous lap, and
/// `lies` false closures.
template <class Group>
CorruptedGraph drive_laps(int laps, int lies, unsigned seed) {
  constexpr int kLap = 12;
  std::mt19937 rng(seed);
  CorruptedGraph g;
  const Noise noise = Noise::isotropic(Group::kDim, 0.01);
  const Group motion = [] {
    typename Group::Tangent v = Group::Tangent::Zero();
    v[0] = 2.0 * M_PI * 5.0 / kLap;
    v[Group::kDim - 1] = 2.0 * M_PI / kLap;
    return Group::exp(v);
  }();
  Group truth, start;
  g.problem.trusted.push_back(std::make_shared<Prior<Group>>(pose(0), truth, noise));
  std::vector<Group> poses = {truth};
  g.problem.initial.insert(pose(0), start);
  for (int i = 1; i < laps * kLap; ++i) {
    const Group measured = motion * random_motion<Group>(0.006, rng);
    truth = truth * motion;
    start = start * measured;
    poses.push_back(truth);
    g.problem.initial.insert(pose(i), start);
    g.problem.trusted.push_back(
        std::make_shared<Between<Group>>(pose(i - 1), pose(i), measured, noise));
  }
  const auto close = [&](int a, int b, const Group& measured, bool is_true) {
    g.problem.closures.push_back(
        std::make_shared<Between<Group>>(pose(a), pose(b), measured, noise));
    g.truth.push_back(is_true);
  };
  for (int i = kLap; i < laps * kLap; ++i) {
    close(i - kLap, i, poses[i - kLap].between(poses[i]) * random_motion<Group>(0.006, rng), true);
  }
  std::uniform_int_distribution<int> any(0, laps * kLap - 1);
  for (int k = 0; k < lies;) {
    const int a = any(rng), b = any(rng);
    if (std::abs(a - b) < 2) continue;
    const Group wrong = poses[a].between(poses[b]) * random_motion<Group>(1.5, rng);
    close(a, b, wrong, false);
    ++k;
  }
  for (std::size_t i = 0; i < poses.size(); ++i) g.poses.insert(pose(i), poses[i]);
  return g;
}

/// The largest distance between an estimated and a true pose (m); both start at the same pose.
template <class Group>
double largest_error(const Values& values, const Values& truth) {
  double largest = 0.0;
  for (Key key : truth.keys()) {
    const auto difference = values.at<Group>(key).between(truth.at<Group>(key));
    largest = std::max(largest, difference.translation().norm());
  }
  return largest;
}

}  // namespace hybrid::testing
