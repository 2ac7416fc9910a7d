// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, the hybrid mapping authors
#include "libhybrid/marginals/observability.h"

#include <gtest/gtest.h>

#include <cmath>

#include "libhybrid/core/error.h"
#include "libhybrid/marginals/continuous.h"
#include "libhybrid/solvers/levenberg_marquardt.h"
#include "tests/support/simulated_bundle.h"

namespace hybrid {
namespace {

using testing::BundleOptions;
using testing::simulate_bundle;
using testing::SimulatedBundle;

const Key kCalibration('k', 0);

Estimate solve(const SimulatedBundle& bundle) {
  return {levenberg_marquardt(bundle.graph, bundle.initial).values, {}};
}

TEST(Observability, BundleAdjustmentRecoversIntrinsics) {
  BundleOptions options;
  double squares = 0.0;
  constexpr int kTrials = 5;
  for (int seed = 1; seed <= kTrials; ++seed) {
    const SimulatedBundle bundle = simulate_bundle(options, seed);
    const Estimate estimate = solve(bundle);
    const ObservedVector camera = observe_vector(bundle.graph, estimate, kCalibration);
    ASSERT_TRUE(camera.all()) << camera.text({"f", "cx", "cy", "k1", "k2"});
    EXPECT_NEAR(camera.values[0], options.intrinsics[0], 1.0);  // pixels
    EXPECT_NEAR(camera.values[1], options.intrinsics[1], 2.0);
    EXPECT_NEAR(camera.values[2], options.intrinsics[2], 2.0);
    EXPECT_NEAR(camera.values[3], options.intrinsics[3], 0.01);
    for (int i = 0; i < 5; ++i) {
      squares += std::pow((camera.values[i] - options.intrinsics[i]) / camera.sigmas[i], 2);
    }
    const ContinuousMarginals marginals(bundle.graph, estimate);
    const Eigen::MatrixXd covariance = marginals.covariance(kCalibration);
    for (int i = 0; i < 5; ++i) {
      EXPECT_NEAR(camera.sigmas[i], std::sqrt(covariance(i, i)), 1e-3 * camera.sigmas[i]);
    }
  }
  EXPECT_LT(squares / (5 * kTrials), 2.5);
  EXPECT_GT(squares / (5 * kTrials), 0.3);
}

TEST(Observability, AWallSeenSquarelyDoesNotGiveTheFocalLength) {
  BundleOptions options;
  options.around = false;
  options.cameras = 8;
  options.start = options.intrinsics;
  SimulatedBundle bundle = simulate_bundle(options, 1);
  Estimate truth{bundle.truth, {}};
  HybridGraph free;
  bundle.graph.continuous().for_each([&](Handle, const ContinuousFactorPtr& factor) {
    if (factor->name() == "projection") free.add(factor);
  });
  for (int i = 0; i < options.cameras; ++i) {
    // The directions of the cameras are known, their positions to a scale only.
    Eigen::VectorXd sigmas(6);
    sigmas << 1e3, 1e3, 1e3, 1e-4, 1e-4, 1e-4;
    free.emplace<Prior<SE3>>(Key('c', i), bundle.truth.at<SE3>(Key('c', i)),
                             Noise::diagonal(sigmas));
  }
  const ObservedVector camera = observe_vector(free, truth, kCalibration);
  // Distances and f grow together by any factor, k1 by its square and k2 by its fourth power.
  EXPECT_EQ(camera.observable, (std::vector<bool>{false, true, true, false, false}))
      << camera.text({"f", "cx", "cy", "k1", "k2"});
  EXPECT_TRUE(std::isnan(camera.values[0]) && std::isnan(camera.sigmas[0]));
  EXPECT_NE(camera.text({"f"}).find("f: unobservable"), std::string::npos);
}

TEST(Observability, CamerasAroundNeedNoFrame) {
  const SimulatedBundle bundle = simulate_bundle({}, 3);
  const Estimate estimate = solve(bundle);
  HybridGraph free;
  bundle.graph.continuous().for_each([&](Handle, const ContinuousFactorPtr& factor) {
    if (factor->name() == "projection") free.add(factor);
  });
  const ObservedVector fixed = observe_vector(bundle.graph, estimate, kCalibration);
  const ObservedVector camera = observe_vector(free, estimate, kCalibration);
  ASSERT_TRUE(camera.all());
  EXPECT_NEAR(camera.sigmas[0], fixed.sigmas[0], 0.05 * fixed.sigmas[0]);
}

TEST(Observability, RefusesWhatIsNoVector) {
  const SimulatedBundle bundle = simulate_bundle({}, 4);
  EXPECT_THROW(observe_vector(bundle.graph, bundle.initial, Key('c', 0)), Error);
  EXPECT_THROW(observe_vector(bundle.graph, bundle.initial, Key('k', 7)), Error);
}

}  // namespace
}  // namespace hybrid
