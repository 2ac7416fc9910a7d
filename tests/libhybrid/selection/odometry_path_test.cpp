// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, the hybrid mapping authors
#include "libhybrid/selection/odometry_path.h"

#include <gtest/gtest.h>

#include <memory>
#include <random>

#include "libhybrid/factors/between.h"
#include "libhybrid/factors/prior.h"
#include "libhybrid/smoother/incremental.h"
#include "tests/support/simulated_graphs.h"

namespace hybrid {
namespace {

using testing::pose;
using testing::random_motion;

template <class Group, class Factor>
struct Case {
  using Pose = Group;
  using Between = Factor;
};

template <class Case>
class OdometryPathOf : public ::testing::Test {
 protected:
  using Pose = typename Case::Pose;
  using Factor = typename Case::Between;

  OdometryPathOf() {
    Delta delta;
    std::vector<Pose> poses(40);
    delta.values.insert(pose(0), poses[0]);
    delta.continuous.push_back(
        std::make_shared<Prior<Pose>>(pose(0), poses[0], Noise::isotropic(Pose::kDim, 1e-4)));
    double x[Pose::kSize];
    poses[0].store(x);
    path.start(pose(0), Variable<Pose>::type(), x);
    for (int i = 1; i < 40; ++i) {
      const Pose z = testing::step_forward<Pose>(0.2) * random_motion<Pose>(0.1, rng);
      poses[i] = poses[i - 1] * z;
      delta.values.insert(pose(i), poses[i]);
      delta.continuous.push_back(
          std::make_shared<Factor>(pose(i - 1), pose(i), z, Noise::isotropic(Pose::kDim, 0.05)));
      // The start is not where the measurement puts the pose.
      (poses[i] * random_motion<Pose>(0.2, rng)).store(x);
      path.append(pose(i - 1), pose(i), *delta.continuous.back(), Variable<Pose>::type(), x);
    }
    smoother.update(delta);
  }

  std::shared_ptr<Factor> closure(int i, int j, double sigma) {
    const Pose z = smoother.values().template at<Pose>(pose(i)).between(
                       smoother.values().template at<Pose>(pose(j))) *
                   random_motion<Pose>(0.1, rng);
    return std::make_shared<Factor>(pose(i), pose(j), z, Noise::isotropic(Pose::kDim, sigma));
  }
  Prediction by_smoother(const ContinuousFactor& factor) const {
    const auto x = gather(factor.keys(), factor.types(), smoother.values());
    return predict_measurement(factor, x.data(), smoother.joint_covariance(factor.keys()));
  }

  std::mt19937 rng{3};
  OdometryPath path;
  IncrementalSmoother smoother;
};

using Cases =
    ::testing::Types<Case<SE2, BetweenSE2>, Case<SE2, Between<SE2>>, Case<SE3, Between<SE3>>>;
TYPED_TEST_SUITE(OdometryPathOf, Cases);

TYPED_TEST(OdometryPathOf, PredictsAsTheSmootherDoesFromOdometryAlone) {
  for (const auto& [i, j] : {std::pair{5, 30}, {30, 5}, {0, 39}, {11, 13}}) {
    const auto factor = this->closure(i, j, 0.3);
    const auto alone = this->path.innovation(*factor);
    ASSERT_TRUE(alone.has_value());
    const Prediction expected = this->by_smoother(*factor);
    EXPECT_NEAR(alone->chi_square, expected.chi_square, 1e-6 * (1 + expected.chi_square));
    EXPECT_NEAR(alone->log_determinant, expected.log_determinant, 1e-6);
    EXPECT_NEAR(alone->redundancy, expected.redundancy, 1e-6);
  }
}

TEST(OdometryPath, SaysNothingWhereNoPathJoins) {
  OdometryPath path;
  const BetweenSE2 step(pose(0), pose(1), SE2(1, 0, 0), Noise::unit(3));
  EXPECT_FALSE(path.innovation(step).has_value());
  double x[SE2::kSize];
  SE2().store(x);
  path.start(pose(0), Variable<SE2>::type(), x);
  path.start(pose(1), Variable<SE2>::type(), x);
  EXPECT_FALSE(path.innovation(step).has_value());
  const Prior<SE2> prior(pose(0), SE2(), Noise::unit(3));
  EXPECT_FALSE(path.innovation(prior).has_value());
}

}  // namespace
}  // namespace hybrid
