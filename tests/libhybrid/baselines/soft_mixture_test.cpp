// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, the hybrid mapping authors
#include "libhybrid/baselines/soft_mixture.h"

#include <gtest/gtest.h>

#include <cmath>
#include <memory>

#include "libhybrid/baselines/max_mixture.h"
#include "libhybrid/hybrid/soft_mixture.h"
#include "tests/support/corrupted_graph.h"

namespace hybrid {
namespace {

TEST(SoftMixtureKernel, WeightIsItsDerivativeAndMaxMixtureItsBound) {
  for (double variance : {100.0, 1e7}) {
    for (double offset : {-3.0, 2.0, 30.0}) {
      const Kernel soft = soft_mixture_kernel(variance, offset);
      const Kernel max = max_mixture_kernel(variance, offset);
      EXPECT_NEAR(soft.value(0.0), 0.0, 1e-12);
      for (double s : {0.1, 2.0, 25.0, 60.0, 1e4}) {
        const double h = 1e-4 * s;
        EXPECT_NEAR((soft.value(s + h) - soft.value(s - h)) / (2.0 * h), soft.weight(s), 1e-4);
        EXPECT_NEAR(soft.value(s), max.value(s) - max.value(0.0), 2.0 * std::log(2.0) + 1e-9);
      }
    }
  }
}

TEST(SoftMixtureKernel, EqualsTheFactor) {
  const auto g = testing::drive_laps<SE2>(2, 2, 1);
  const ContinuousFactorPtr closure = g.problem.closures.back();
  const auto* between = dynamic_cast<const Between<SE2>*>(closure.get());
  ASSERT_NE(between, nullptr);
  MixtureOptions mixture;
  mixture.inlier_weight = 0.8;
  mixture.outlier_weight = 0.2;
  const auto wide =
      std::make_shared<Between<SE2>>(closure->keys()[0], closure->keys()[1], between->measured(),
                                     Noise::isotropic(3, 0.01).inflated(mixture.outlier_variance));
  const SoftMixture soft({{closure, -std::log(0.8)}, {wide, -std::log(0.2)}});
  const double s = 2.0 * closure->cost(g.problem.initial);
  EXPECT_NEAR(2.0 * soft.cost(g.problem.initial), soft_mixture_kernel(*closure, mixture).value(s),
              1e-6 * (1.0 + s));
}

TEST(SolveSoftMixture, TellsLiesFromTruth) {
  const auto g = testing::drive_laps<SE2>(4, 12, 3);
  const RobustResult result = solve_soft_mixture(g.problem);
  EXPECT_EQ(result.method, "sum-mixture");
  for (std::size_t k = 0; k < g.truth.size(); ++k) {
    EXPECT_EQ(result.decisions[k].accepted(), g.truth[k]) << k;
  }
}

}  // namespace
}  // namespace hybrid
