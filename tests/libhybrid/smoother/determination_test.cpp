// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, the hybrid mapping authors

#include <gtest/gtest.h>

#include "libhybrid/factors/between.h"
#include "libhybrid/factors/prior.h"
#include "libhybrid/smoother/incremental.h"

namespace hybrid {
namespace {

// The motion is so much more certain than the place that pivots are lost in rounding, in the update
// that brings the variables and in later ones that bring none.
TEST(Determination, HoldsWherePivotsAreLostAndNothingIsNew) {
  for (const double sigma : {1e-7, 1e-8}) {
    IncrementalSmoother smoother;
    Delta delta;
    for (std::uint64_t i = 0; i < 4; ++i) {
      delta.values.insert(Key('x', i), SE2(static_cast<double>(i), 0.1, 0.3));
    }
    delta.continuous.push_back(
        std::make_shared<Prior<SE2>>(Key('x', 0), SE2(), Noise::isotropic(3, 1.0)));
    for (std::uint64_t i = 1; i < 4; ++i) {
      delta.continuous.push_back(std::make_shared<BetweenSE2>(
          Key('x', i - 1), Key('x', i), SE2(1, 0, 0.1), Noise::isotropic(3, sigma)));
    }
    if (smoother.update(delta).status != UpdateReport::Status::kOk) continue;
    EXPECT_EQ(smoother.converge().status, UpdateReport::Status::kOk) << sigma;
    EXPECT_EQ(smoother.update({}).status, UpdateReport::Status::kOk) << sigma;
    const Values& values = smoother.estimate().values;
    const SE2 motion = values.at<SE2>(Key('x', 0)).inverse() * values.at<SE2>(Key('x', 1));
    EXPECT_TRUE(motion.translation().isApprox(Eigen::Vector2d(1, 0), 1e-5)) << sigma;
  }
}

}  // namespace
}  // namespace hybrid
