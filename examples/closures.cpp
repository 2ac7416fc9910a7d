// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, the hybrid mapping authors

// A loop with three true and three false closures: which ones are accepted?
#include <cmath>
#include <iostream>
#include <memory>

#include "libhybrid/factors/between.h"
#include "libhybrid/factors/prior.h"
#include "libhybrid/selection/closure_selection.h"

int main() {
  using namespace hybrid;
  const Noise odometry = Noise::diagonal(Eigen::Vector3d(0.05, 0.05, 0.01));
  const Noise closure = Noise::diagonal(Eigen::Vector3d(0.05, 0.05, 0.02));
  RobustProblem problem;
  Values truth;
  // Two rounds on a circle.
  const std::uint64_t round = 30;
  for (std::uint64_t i = 0; i < 2 * round; ++i) {
    const double angle = 2 * M_PI * static_cast<double>(i) / static_cast<double>(round);
    const SE2 pose(5 * std::cos(angle), 5 * std::sin(angle), angle + M_PI / 2);
    truth.insert(Key('x', i), pose);
    if (i == 0) {
      problem.trusted.push_back(std::make_shared<Prior<SE2>>(Key('x', 0), pose, odometry));
      problem.initial.insert(Key('x', 0), pose);
      continue;
    }
    const Key before('x', i - 1);
    const SE2 motion = truth.at<SE2>(before).between(pose) * SE2(0.01, 0.005, 0.002);
    problem.trusted.push_back(std::make_shared<BetweenSE2>(before, Key('x', i), motion, odometry));
    problem.initial.insert(Key('x', i), problem.initial.at<SE2>(before) * motion);
  }
  for (std::uint64_t i : {2, 12, 22}) {
    const Key from('x', i), to('x', i + round), wrong('x', i + round / 2);
    problem.closures.push_back(std::make_shared<BetweenSE2>(
        from, to, truth.at<SE2>(from).between(truth.at<SE2>(to)), closure));
    problem.closures.push_back(std::make_shared<BetweenSE2>(from, wrong, SE2(), closure));
  }
  const RobustResult result = select_closures(problem);
  bool right = true;
  for (std::size_t k = 0; k < result.decisions.size(); ++k) {
    const ClosureDecision& decision = result.decisions[k];
    const bool is_true = k % 2 == 0;
    std::cout << (is_true ? "true " : "false")
              << " closure: " << (decision.accepted() ? "accepted" : "rejected") << ", probability "
              << decision.inlier_probability << '\n';
    right = right && decision.accepted() == is_true;
  }
  return right ? 0 : 1;
}
