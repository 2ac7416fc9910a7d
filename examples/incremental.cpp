// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, the hybrid mapping authors

// A robot drives a square, pose by pose, and closes the loop. The cost of an update depends on the
// variables it affects.
#include <cmath>
#include <iostream>
#include <memory>

#include "libhybrid/factors/between.h"
#include "libhybrid/factors/prior.h"
#include "libhybrid/smoother/window.h"

int main() {
  using namespace hybrid;
  const Noise noise = Noise::isotropic(3, 0.05);
  const SE2 step(1, 0, 0), turn(1, 0, M_PI / 2);
  // All poses stay; mode kFixedLag with a lag would marginalise old ones.
  WindowSmoother smoother;
  for (std::uint64_t i = 0; i < 40; ++i) {
    Delta delta;  // all changes of one keyframe, applied together or not at all
    const Key pose('x', i), before('x', i - 1);
    if (i == 0) {
      delta.values.insert(pose, SE2());
      delta.continuous.push_back(std::make_shared<Prior<SE2>>(pose, SE2(), noise));
    } else {
      const SE2 motion = i % 10 == 0 ? turn : step;
      // The measured distance is two per cent too long.
      const SE2 measured(1.02 * motion.x(), 0, motion.angle());
      delta.values.insert(pose, smoother.smoother().values().at<SE2>(before) * measured);
      delta.continuous.push_back(std::make_shared<BetweenSE2>(before, pose, measured, noise));
    }
    if (i == 39) {
      delta.continuous.push_back(
          std::make_shared<BetweenSE2>(pose, Key('x', 0), turn, Noise::isotropic(3, 0.01)));
    }
    const WindowReport report = smoother.update(delta);
    if (report.status != UpdateReport::Status::kOk) {
      std::cerr << report.message << '\n';
      return 1;
    }
    if (i % 13 == 0) {
      std::cout << "pose " << i << ": " << report.eliminated << " variables eliminated again\n";
    }
  }
  smoother.converge();
  const SE2 last = smoother.smoother().values().at<SE2>(Key('x', 39));
  std::cout << "the last pose is at " << last.x() << ' ' << last.y()
            << " m, 1 m before the start\n";
  return std::hypot(last.x() - 0, last.y() - 1) < 0.2 ? 0 : 1;
}
