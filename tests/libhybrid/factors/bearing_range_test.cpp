// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, the hybrid mapping authors
#include "libhybrid/factors/bearing_range.h"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>

#include "libhybrid/factors/expect_jacobians.h"
#include "tests/support/random.h"

namespace hybrid {
namespace {

using testing::expect_jacobians;
using testing::expect_robust_gradient;
using testing::linearization;
using testing::Random;

const Key kPose{'x', 1};
const Key kPoint{'l', 2};

template <class Pose>
class BearingRangeTest : public ::testing::Test {
 protected:
  using Point = typename Pose::Point;
  static constexpr int kRows = Point::RowsAtCompileTime;

  Values values(const Pose& pose, const Point& point) const {
    Values v;
    v.insert(kPose, pose);
    v.insert(kPoint, point);
    return v;
  }
  Point measurement() {
    Point z = random.vector<kRows>();
    z[0] = random.uniform(0.5, 5.0);
    return z;
  }

  Random random{7};
};

using Poses = ::testing::Types<SE2, SE3>;
TYPED_TEST_SUITE(BearingRangeTest, Poses);

TYPED_TEST(BearingRangeTest, JacobiansAgreeWithNumericOnes) {
  for (int trial = 0; trial < 20; ++trial) {
    const BearingRange<TypeParam> factor(kPose, kPoint, this->measurement(),
                                         this->random.noise(this->kRows),
                                         this->random.template value<TypeParam>());
    const Values values =
        this->values(this->random.template value<TypeParam>(),
                     3.0 * this->random.template value<typename TypeParam::Point>());
    expect_jacobians(factor, values, 1e-6);
  }
}

TYPED_TEST(BearingRangeTest, RobustGradientAgreesWithNumericOne) {
  for (const Loss& loss :
       {Loss::huber(), Loss::cauchy(), Loss::tukey(8.0), Loss::geman_mcclure()}) {
    const BearingRange<TypeParam> factor(kPose, kPoint, this->measurement(),
                                         this->random.noise(this->kRows),
                                         this->random.template value<TypeParam>(), loss);
    expect_robust_gradient(
        factor,
        this->values(this->random.template value<TypeParam>(),
                     3.0 * this->random.template value<typename TypeParam::Point>()),
        1e-6);
  }
}

TYPED_TEST(BearingRangeTest, LocatedPointHasZeroResidual) {
  for (int trial = 0; trial < 20; ++trial) {
    const auto pose = this->random.template value<TypeParam>();
    const auto sensor = this->random.template value<TypeParam>();
    auto z = this->measurement();
    const Noise noise = this->random.noise(this->kRows, 0.1);
    const BearingRange<TypeParam> factor(kPose, kPoint, z, noise, sensor);
    const auto located = locate(pose, z, noise, sensor);
    if (this->kRows == 3 && std::abs(z[2]) > M_PI / 2) continue;  // beyond the pole
    EXPECT_LT(factor.evaluate(pose, located.mean, nullptr, nullptr).norm(), 1e-9);
    // The information of the factor about the point, its pose fixed, is that of the location.
    const auto l = linearization(factor, this->values(pose, located.mean));
    const Eigen::MatrixXd J = l.J.rightCols(this->kRows);
    EXPECT_LT(((J.transpose() * J).inverse() - located.covariance).norm(),
              1e-8 * (1.0 + located.covariance.norm()));
  }
}

TYPED_TEST(BearingRangeTest, LocatedCovarianceIncludesThePose) {
  const auto pose = this->random.template value<TypeParam>();
  const auto sensor = this->random.template value<TypeParam>();
  const auto z = this->measurement();
  const Noise noise = this->random.noise(this->kRows, 0.1);
  const Noise pose_noise = this->random.noise(TypeParam::kDim, 0.1);
  const auto alone = locate(pose, z, noise, sensor);
  const auto both = locate<TypeParam>(pose, z, noise, sensor, pose_noise.covariance());
  Eigen::Matrix<double, TypeParam::Point::RowsAtCompileTime, TypeParam::kDim> J;
  for (int d = 0; d < TypeParam::kDim; ++d) {
    const typename TypeParam::Tangent step = 1e-6 * TypeParam::Tangent::Unit(d);
    J.col(d) = (locate<TypeParam>(pose * TypeParam::exp(step), z, noise, sensor).mean -
                locate<TypeParam>(pose * TypeParam::exp(-step), z, noise, sensor).mean) /
               2e-6;
  }
  EXPECT_LT(
      (both.covariance - alone.covariance - J * pose_noise.covariance() * J.transpose()).norm(),
      1e-7);
}

TYPED_TEST(BearingRangeTest, AnglesAreWrapped) {
  typename TypeParam::Point z = TypeParam::Point::Zero();
  z[0] = 1.0;
  z[1] = M_PI - 0.01;
  const BearingRange<TypeParam> factor(kPose, kPoint, z, Noise::unit(this->kRows));
  typename TypeParam::Point p = TypeParam::Point::Zero();
  p[0] = -1.0;
  p[1] = -0.01;
  EXPECT_NEAR(factor.evaluate(TypeParam(), p, nullptr, nullptr)[1], 0.02, 1e-4);
}

TYPED_TEST(BearingRangeTest, IsFiniteAtTheSensorAndOnItsAxis) {
  auto z = this->measurement();
  const BearingRange<TypeParam> factor(kPose, kPoint, z, Noise::unit(this->kRows));
  for (double scale : {0.0, 1e-300, 1e-12, 1e-6}) {
    for (int axis = 0; axis < this->kRows; ++axis) {
      const typename TypeParam::Point p = scale * TypeParam::Point::Unit(axis);
      const auto l = linearization(factor, this->values(TypeParam(), p));
      EXPECT_TRUE(l.r.allFinite() && l.J.allFinite() && std::isfinite(l.cost)) << scale;
      const typename TypeParam::Point on_axis = p + TypeParam::Point::Unit(this->kRows - 1);
      EXPECT_TRUE(linearization(factor, this->values(TypeParam(), on_axis)).J.allFinite());
    }
  }
}

TYPED_TEST(BearingRangeTest, RefusesAbsurdMeasurements) {
  using Factor = BearingRange<TypeParam>;
  const Noise noise = Noise::unit(this->kRows);
  typename TypeParam::Point z = TypeParam::Point::Ones();
  EXPECT_NO_THROW(Factor(kPose, kPoint, z, noise));
  EXPECT_THROW(Factor(kPose, kPoint, z, Noise::unit(this->kRows + 1)), Error);
  z[0] = -1.0;
  EXPECT_THROW(Factor(kPose, kPoint, z, noise), Error);
  z[0] = 1.0;
  z[1] = std::numeric_limits<double>::quiet_NaN();
  EXPECT_THROW(Factor(kPose, kPoint, z, noise), Error);
}

TEST(BearingRange3, PitchIsNegativeAboveTheSensor) {
  // Range 1.41421, yaw 0 and pitch -0.785398 is what MRPT's sphericalCoordinates answers here.
  const BearingRange3 factor(kPose, kPoint, {std::sqrt(2.0), 0.0, -M_PI / 4}, Noise::unit(3));
  EXPECT_LT(factor.evaluate(SE3(), {1.0, 0.0, 1.0}, nullptr, nullptr).norm(), 1e-12);
}

}  // namespace
}  // namespace hybrid
