// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, the hybrid mapping authors
#include "libhybrid/marginals/observability.h"

#include <gtest/gtest.h>

#include <cmath>

#include "libhybrid/core/error.h"
#include "libhybrid/factors/range.h"
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

/// Holds the directions of a camera, and not where it is.
class KnownRotation : public FactorOf<3, SE3> {
 public:
  KnownRotation(Key key, const SO3& rotation, double sigma)
      : FactorOf({key}, Noise::isotropic(3, sigma)), rotation_(rotation) {}
  std::string name() const override { return "known rotation"; }
  Residual evaluate(const SE3& T, Jacobian<SE3>* J) const override {
    SO3::Jacobian by_rotation;
    const Residual e = rotation_.between(T.rotation()).log(&by_rotation);
    if (J != nullptr) *J << Eigen::Matrix3d::Zero(), by_rotation;
    return e;
  }

 private:
  SO3 rotation_;
};

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
  HybridGraph placed = free, vague = free;
  for (int i = 0; i < options.cameras; ++i) {
    // The directions of the cameras are known, their positions to a scale only; or to a centimetre.
    const SE3 T = bundle.truth.at<SE3>(Key('c', i));
    free.emplace<KnownRotation>(Key('c', i), T.rotation(), 1e-4);
    placed.emplace<Prior<SE3>>(Key('c', i), T, Noise::isotropic(6, 0.01));
    vague.emplace<Prior<SE3>>(Key('c', i), T, Noise::isotropic(6, 0.01));
  }
  // The distance of the wall and f grow together by any factor, k1 by its square and k2 by its
  // fourth power, wherever the cameras are.
  for (const HybridGraph* graph : {&free, &placed}) {
    const ObservedVector camera = observe_vector(*graph, truth, kCalibration);
    EXPECT_EQ(camera.observable, (std::vector<bool>{false, true, true, false, false}))
        << camera.text({"f", "cx", "cy", "k1", "k2"});
    EXPECT_TRUE(std::isnan(camera.values[0]) && std::isnan(camera.sigmas[0]));
    EXPECT_NE(camera.text({"f"}).find("f: unobservable"), std::string::npos);
    const ContinuousMarginals marginals(*graph, truth);
    EXPECT_THROW(marginals.covariance(kCalibration), Error);
  }
  // A prior determines it, to many times its value: that is no secret either.
  const Intrinsics sigmas = (Intrinsics() << 1e4, 1e4, 1e4, 1e4, 1e4).finished();
  vague.emplace<Prior<Intrinsics>>(kCalibration, options.intrinsics, Noise::diagonal(sigmas));
  const ObservedVector told = observe_vector(vague, truth, kCalibration);
  EXPECT_TRUE(told.all());
  EXPECT_NEAR(told.sigmas[0], 1e4, 100.0);
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

TEST(Observability, OneRangeGivesThePointAlongItsLineOnly) {
  HybridGraph graph;
  using Point = Eigen::Vector2d;
  graph.emplace<Prior<Point>>(Key('x', 0), Point(0, 0), Noise::isotropic(2, 0.1));
  graph.emplace<Range<Point, Point>>(Key('x', 0), Key('l', 0), 1.0, Noise::isotropic(1, 0.1));
  Estimate estimate;
  estimate.values.insert(Key('x', 0), Point(0, 0));
  estimate.values.insert(Key('l', 0), Point(1, 0));
  const ObservedVector ahead = observe_vector(graph, estimate, Key('l', 0));
  EXPECT_EQ(ahead.observable, (std::vector<bool>{true, false})) << ahead.text({"x", "y"});
  EXPECT_NEAR(ahead.sigmas[0], std::sqrt(0.02), 1e-9);
  EXPECT_TRUE(std::isnan(ahead.sigmas[1]));
  estimate.values.update(Key('l', 0), Point(0, 1));
  EXPECT_EQ(observe_vector(graph, estimate, Key('l', 0)).observable,
            (std::vector<bool>{false, true}));
  estimate.values.update(Key('l', 0), Point(std::sqrt(0.5), std::sqrt(0.5)));
  EXPECT_EQ(observe_vector(graph, estimate, Key('l', 0)).observable,
            (std::vector<bool>{false, false}));
  EXPECT_TRUE(observe_vector(graph, estimate, Key('x', 0)).all());
}

TEST(Observability, RefusesWhatIsNoVector) {
  const SimulatedBundle bundle = simulate_bundle({}, 4);
  EXPECT_THROW(observe_vector(bundle.graph, bundle.initial, Key('c', 0)), Error);
  EXPECT_THROW(observe_vector(bundle.graph, bundle.initial, Key('k', 7)), Error);
}

}  // namespace
}  // namespace hybrid
