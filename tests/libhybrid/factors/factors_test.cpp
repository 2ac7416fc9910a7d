// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, the hybrid mapping authors
#include <gtest/gtest.h>

#include <Eigen/LU>
#include <cmath>
#include <limits>

#include "libhybrid/factors/bearing.h"
#include "libhybrid/factors/between.h"
#include "libhybrid/factors/expect_jacobians.h"
#include "libhybrid/factors/position.h"
#include "libhybrid/factors/prior.h"
#include "libhybrid/factors/range.h"
#include "libhybrid/factors/relative_poses.h"
#include "tests/support/random.h"

namespace hybrid {
namespace {

using Eigen::Vector2d;
using Eigen::Vector3d;
using testing::expect_jacobians;
using testing::expect_robust_gradient;
using testing::linearization;
using testing::Random;

const Key kA{'a', 1};
const Key kB{'b', 2};
constexpr double kNaN = std::numeric_limits<double>::quiet_NaN();

/// Calls check(factor, values) on `count` random configurations, without a loss and with some.
template <class A, class B, class Make>
void for_random_pairs(Make&& make, double tolerance = 1e-6) {
  Random random{3};
  for (int trial = 0; trial < 20; ++trial) {
    Values values;
    values.insert(kA, random.value<A>());
    values.insert(kB, random.value<B>(2.0));
    expect_jacobians(*make(random, Loss::none()), values, tolerance);
    expect_robust_gradient(*make(random, Loss::cauchy()), values, tolerance);
    expect_robust_gradient(*make(random, Loss::geman_mcclure(5.0)), values, tolerance);
  }
}

template <class A, class Make>
void for_random_values(Make&& make) {
  for_random_pairs<A, A>(std::forward<Make>(make));
}

template <class T>
void check_prior() {
  for_random_values<T>([](Random& random, Loss loss) {
    return std::make_shared<Prior<T>>(kA, random.value<T>(), random.noise(Variable<T>::kDim), loss);
  });
}

TEST(Prior, Jacobians) {
  check_prior<SO2>();
  check_prior<SE2>();
  check_prior<SO3>();
  check_prior<SE3>();
  check_prior<Vector2d>();
  check_prior<Vector3d>();
  check_prior<Eigen::Matrix<double, 5, 1>>();
}

template <class T>
void check_between() {
  for_random_values<T>([](Random& random, Loss loss) {
    return std::make_shared<Between<T>>(kA, kB, random.value<T>(), random.noise(T::kDim), loss);
  });
}

TEST(Between, Jacobians) {
  check_between<SO2>();
  check_between<SE2>();
  check_between<SO3>();
  check_between<SE3>();
}

TEST(BetweenSE2, Jacobians) {
  for_random_values<SE2>([](Random& random, Loss loss) {
    return std::make_shared<BetweenSE2>(kA, kB, random.value<SE2>(), random.noise(3), loss);
  });
}

TEST(Between, DiagonalNoiseWhitensAsItsFullForm) {
  Random random{5};
  const SE3 z = random.value<SE3>();
  const Eigen::VectorXd sigmas = random.vector<6>().array().abs() + 0.1;
  Values values;
  values.insert(kA, random.value<SE3>());
  values.insert(kB, random.value<SE3>());
  const Between<SE3> factor(kA, kB, z, Noise::diagonal(sigmas));
  const Between<SE3> unit(kA, kB, z, Noise::unit(6));
  const auto l = linearization(factor, values);
  const auto u = linearization(unit, values);
  EXPECT_LT((l.J - sigmas.cwiseInverse().asDiagonal() * u.J).norm(), 1e-12 * l.J.norm());
  EXPECT_LT((l.r - sigmas.cwiseInverse().asDiagonal() * u.r).norm(), 1e-12 * l.r.norm());
}

template <class Group>
void check_zero_at_measurement() {
  Random random{9};
  const Group a = random.value<Group>();
  const Group z = random.value<Group>();
  const Between<Group> factor(kA, kB, z, Noise::unit(Group::kDim));
  EXPECT_LT(factor.evaluate(a, a * z, nullptr, nullptr).norm(), 1e-12);
}

TEST(Between, IsZeroAtTheMeasurement) {
  check_zero_at_measurement<SO2>();
  check_zero_at_measurement<SE2>();
  check_zero_at_measurement<SO3>();
  check_zero_at_measurement<SE3>();
}

TEST(BetweenSE2, BothResidualsAgreeToFirstOrder) {
  Random random{11};
  const SE2 a = random.value<SE2>();
  const SE2 z = random.value<SE2>();
  const SE2 b = a * z * SE2::exp(random.vector<3>(1e-5));
  const Between<SE2> log_form(kA, kB, z, Noise::unit(3));
  const BetweenSE2 plain_form(kA, kB, z, Noise::unit(3));
  const Vector3d e = log_form.evaluate(a, b, nullptr, nullptr);
  EXPECT_GT(e.norm(), 1e-6);
  EXPECT_LT((e - plain_form.evaluate(a, b, nullptr, nullptr)).norm(), 1e-9);
}

template <class A, class B>
void check_range_jacobians() {
  using Point = typename Range<A, B>::Point;
  for_random_pairs<A, B>(
      [](Random& random, Loss loss) {
        return std::make_shared<Range<A, B>>(kA, kB, random.uniform(0.0, 5.0), random.noise(1),
                                             random.value<Point>(), random.value<Point>(), loss);
      },
      1e-5);
}

TEST(Range, Jacobians) {
  check_range_jacobians<SE2, Vector2d>();
  check_range_jacobians<SE3, Vector3d>();
  check_range_jacobians<Vector2d, Vector2d>();
  check_range_jacobians<Vector3d, Vector3d>();
  check_range_jacobians<SE2, SE2>();
  check_range_jacobians<SE3, SE3>();
}

TEST(Range, MeasuresBetweenTheAntennas) {
  const Range<SE2, Vector2d> factor(kA, kB, 1.0, Noise::unit(1), {1.0, 0.0});
  EXPECT_NEAR(factor.evaluate({2.0, 0.0, M_PI / 2}, {2.0, 4.0}, nullptr, nullptr)[0], 2.0, 1e-12);
}

// Where the distance has no derivative, that in one direction stands in: the first axis of the
// pose.
TEST(Range, HasADirectionAtZeroDistance) {
  Random random{6};
  const SE3 pose = random.value<SE3>();
  const Range<SE3, Vector3d> factor(kA, kB, 1.0, Noise::unit(1));
  Values values;
  values.insert(kA, pose);
  values.insert(kB, pose.translation());
  const auto at = linearization(factor, values);
  EXPECT_EQ(at.r[0], -1.0);
  for (double ahead : {1e-7, 1.0}) {
    values.update(kB, Vector3d(pose * Vector3d(ahead, 0.0, 0.0)));
    EXPECT_LT((linearization(factor, values).J - at.J).norm(), 1e-6) << ahead;
  }
}

template <class Pose>
void check_bearing_jacobians() {
  using Factor = Bearing<Pose>;
  for_random_pairs<Pose, typename Pose::Point>(
      [](Random& random, Loss loss) {
        return std::make_shared<Factor>(kA, kB, random.vector<Factor::kRows>(),
                                        random.noise(Factor::kRows), random.value<Pose>(), loss);
      },
      1e-5);
}

TEST(Bearing, Jacobians) {
  check_bearing_jacobians<SE2>();
  check_bearing_jacobians<SE3>();
}

TEST(Bearing, WrapsAndFollowsTheSensor) {
  const SE2 T_robot_sensor(0.5, 0.0, M_PI / 2);
  const Bearing2 factor(kA, kB, Eigen::Matrix<double, 1, 1>(3.0), Noise::unit(1), T_robot_sensor);
  // Straight behind a sensor that looks to the left: bearing pi.
  EXPECT_NEAR(factor.evaluate({}, {0.5, -2.0}, nullptr, nullptr)[0], M_PI - 3.0, 1e-12);
  EXPECT_NEAR(factor.evaluate({}, {0.4, -20.0}, nullptr, nullptr)[0], M_PI - 3.0 - 0.005, 1e-5);
  EXPECT_NEAR(factor.evaluate({}, {0.6, -20.0}, nullptr, nullptr)[0], M_PI - 3.0 + 0.005, 1e-5);
}

template <class Pose>
void check_position_jacobians() {
  using Point = typename Pose::Point;
  for_random_values<Pose>([](Random& random, Loss loss) {
    return std::make_shared<Position<Pose>>(kA, random.value<Point>(),
                                            random.noise(Point::RowsAtCompileTime),
                                            random.value<Point>(), loss);
  });
}

TEST(Position, Jacobians) {
  check_position_jacobians<SE2>();
  check_position_jacobians<SE3>();
}

TEST(Position, MeasuresTheEndOfTheLeverArm) {
  const Position2 factor(kA, {1.0, 2.0}, Noise::unit(2), {1.0, 0.0});
  const SE2 pose(1.0, 1.0, M_PI / 2);
  EXPECT_LT(factor.evaluate(pose, nullptr).norm(), 1e-12);
}

TEST(Factors, RefuseAbsurdMeasurements) {
  const Noise noise = Noise::unit(1);
  using R = Range<Vector2d, Vector2d>;
  EXPECT_THROW(R(kA, kB, -0.1, noise), Error);
  EXPECT_THROW(R(kA, kB, kNaN, noise), Error);
  EXPECT_THROW(R(kA, kA, 1.0, noise), Error);
  EXPECT_THROW(Prior<Vector2d>(kA, {0.0, 0.0}, Noise::unit(2), Loss::huber(0.0)), Error);
  EXPECT_THROW(Bearing2(kA, kB, Eigen::Matrix<double, 1, 1>(kNaN), noise), Error);
  EXPECT_THROW(Position2(kA, {0.0, kNaN}, Noise::unit(2)), Error);
  EXPECT_THROW(Prior<Vector2d>(kA, {0.0, kNaN}, Noise::unit(2)), Error);
  EXPECT_THROW(Prior<SE2>(kA, SE2(kNaN, 0.0, 0.0), Noise::unit(3)), Error);
  EXPECT_THROW(BetweenSE2(kA, kB, SE2(0.0, 0.0, kNaN), Noise::unit(3)), Error);
  EXPECT_THROW(Between<SE3>(kA, kB, SE3({kNaN, 0.0, 0.0}, SO3()), Noise::unit(6)), Error);
}

TEST(Factors, NameTheVariablesOfAnAbsurdMeasurement) {
  const auto message = [](const auto& make) {
    try {
      make();
    } catch (const Error& error) {
      return std::string(error.what());
    }
    return std::string();
  };
  const std::string on = " factor on " + to_string(kA) + " " + to_string(kB) + ": the measured ";
  EXPECT_EQ(message([] { BetweenSE2(kA, kB, SE2(0.0, 0.0, kNaN), Noise::unit(3)); }),
            "between" + on + "motion is not finite");
  EXPECT_EQ(message([] { Range<Vector2d, Vector2d>(kA, kB, -1.5, Noise::unit(1)); }),
            "range" + on + "range must be finite and not negative, got -1.500000");
}

TEST(Factors, NameTheVariableThatIsMissingOrOfAnotherType) {
  const Position2 factor(kA, {0.0, 0.0}, Noise::unit(2));
  Values values;
  EXPECT_THROW(factor.cost(values), Error);
  values.insert(kA, SE3());
  try {
    factor.cost(values);
    FAIL() << "an SE3 was taken as SE2";
  } catch (const Error& error) {
    EXPECT_NE(std::string(error.what()).find("a1 is SE3"), std::string::npos) << error.what();
  }
}

TEST(Factors, LogNormalizerIsThatOfTheNoise) {
  Random random{13};
  const Noise noise = random.noise(2);
  const Position2 factor(kA, {0.0, 0.0}, noise);
  EXPECT_NEAR(factor.log_normalizer(),
              std::log(2.0 * M_PI) + 0.5 * std::log(noise.covariance().determinant()), 1e-10);
}

template <class Group>
void check_relative_poses() {
  const Key c{'c', 3};
  Random random{5};
  for (int trial = 0; trial < 10; ++trial) {
    Values values;
    std::vector<Group> poses;
    for (Key key : {kA, kB, c}) {
      poses.push_back(random.value<Group>(2.0));
      values.insert(key, poses.back());
    }
    expect_jacobians(
        RelativePoses<Group>({kA, kB, c}, {random.value<Group>(), random.value<Group>()},
                             random.noise(2 * Group::kDim)),
        values, 1e-6);
    // A marginal is satisfied where it was made, and wherever all poses move together.
    const Eigen::MatrixXd R = random.noise(3 * Group::kDim).sqrt_information();
    const auto marginal = RelativePoses<Group>::marginal({kA, kB, c}, poses, R.transpose() * R);
    EXPECT_LT(marginal.cost(values), 1e-20);
    const Group motion = random.value<Group>();
    for (Key key : {kA, kB, c}) values.update(key, motion * values.at<Group>(key));
    EXPECT_LT(marginal.cost(values), 1e-20);
  }
}

TEST(RelativePoses, JacobiansAndFreedom) {
  check_relative_poses<SE2>();
  check_relative_poses<SE3>();
}

TEST(RelativePoses, OfAChainAreItsSteps) {
  // x0 held, then two steps: seen from x0, the end of the first has the noise of that step.
  Eigen::MatrixXd P = Eigen::MatrixXd::Zero(6, 6);
  const SE2 step(1.0, 0.5, 0.3);
  const Noise noise = Noise::diagonal(Vector3d(0.1, 0.2, 0.05));
  const Eigen::Matrix3d first = Vector3d(0.3, 0.2, 0.1).cwiseAbs2().asDiagonal();
  const Eigen::Matrix3d A = step.inverse().adjoint();
  P.topLeftCorner<3, 3>() = first;
  P.bottomLeftCorner<3, 3>() = A * first;
  P.topRightCorner<3, 3>() = first * A.transpose();
  P.bottomRightCorner<3, 3>() = A * first * A.transpose() + noise.covariance();
  const auto marginal = RelativePoses<SE2>::marginal({kA, kB}, {SE2(), step}, P);
  EXPECT_NEAR(marginal.log_normalizer(), noise.log_normalizer(), 1e-9);
  const Between<SE2> expected(kA, kB, step, noise);
  Values values;
  values.insert(kA, SE2(0.2, 0.1, 0.1));
  values.insert(kB, SE2(1.5, 0.7, 0.3));
  EXPECT_NEAR(marginal.cost(values), expected.cost(values), 1e-9);
  EXPECT_THROW(RelativePoses<SE2>({kA, kB}, {step, step}, noise), Error);
}

}  // namespace
}  // namespace hybrid
