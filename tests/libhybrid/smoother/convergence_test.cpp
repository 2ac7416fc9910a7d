// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, the hybrid mapping authors
// Where the smoother ends is where an independent solver finds nothing left to gain.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <string>

#include "libhybrid/smoother/incremental.h"
#include "libhybrid/solvers/levenberg_marquardt.h"
#include "tests/support/changing_world.h"

namespace hybrid {
namespace {

TEST(Convergence, LeavesNothingToLevenbergMarquardt) {
  for (int seed = 1; seed <= 12; ++seed) {
    SCOPED_TRACE("seed " + std::to_string(seed));
    testing::ChangingWorld world(seed);
    IncrementalSmoother smoother;
    for (int k = 0; k < 30; ++k) world.step(smoother);
    ASSERT_EQ(smoother.converge(1000, 0.0).status, UpdateReport::Status::kOk);
    const double reached = smoother.objective();
    SolverOptions options;
    options.relative_decrease = 1e-12;
    const SolverResult batch = levenberg_marquardt(smoother.graph(), smoother.estimate(), options);
    EXPECT_LE(reached - objective(smoother.graph(), batch.values, smoother.assignment()),
              1e-9 * std::max(1.0, std::abs(reached)));
  }
}

}  // namespace
}  // namespace hybrid
