// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, the hybrid mapping authors
// Windows are as sure of the newest pose as their errors allow.
#include "tests/support/consistency.h"

#include <gtest/gtest.h>

namespace hybrid {
namespace {

using testing::PoseError;
using testing::WalkOptions;

/// Mean NEES of the newest pose over some runs of the simulated world, by mode.
template <class Pose>
double mean_nees(WindowOptions::Mode mode, const WalkOptions& options, int runs, int steps) {
  WindowOptions window;
  window.mode = mode;
  window.lag = 10;
  double sum = 0.0;
  for (int run = 0; run < runs; ++run) {
    testing::walk<Pose>(
        window, options, steps, 1000 + static_cast<std::uint64_t>(run),
        [&](int, const WindowSmoother&, const PoseError& error) { sum += error.nees; });
  }
  return sum / (runs * steps);
}

/// Windows against full smoothing on the same runs. The mean of a NEES over 40 runs has a standard
/// error of about 5 %; of windows whose priors hold what was never measured it is two to three
/// times that of full smoothing.
template <class Pose>
void expect_consistent(const WalkOptions& options, int runs, int steps) {
  const double full = mean_nees<Pose>(WindowOptions::Mode::kFull, options, runs, steps);
  EXPECT_NEAR(full, 1.0, 0.25);
  for (const auto mode : {WindowOptions::Mode::kFixedLag, WindowOptions::Mode::kFilter}) {
    const double nees = mean_nees<Pose>(mode, options, runs, steps);
    EXPECT_NEAR(nees / full, 1.0, 0.2) << static_cast<int>(mode);
  }
}

TEST(WindowConsistency, InThePlane) {
  expect_consistent<SE2>({}, 40, 120);
}

TEST(WindowConsistency, InSpace) {
  WalkOptions options;
  options.landmarks = 60;
  options.spread = 6.0;
  expect_consistent<SE3>(options, 40, 60);
}

}  // namespace
}  // namespace hybrid
