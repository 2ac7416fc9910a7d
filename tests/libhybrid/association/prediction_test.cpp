// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, the hybrid mapping authors
#include "libhybrid/association/prediction.h"

#include <gtest/gtest.h>

#include <Eigen/LU>

#include "libhybrid/association/gate.h"
#include "libhybrid/geometry/se2.h"
#include "libhybrid/geometry/se3.h"

namespace hybrid {
namespace {

TEST(GaussianScore, IsTheDensity) {
  const Eigen::Vector2d r(0.5, -1);
  const Eigen::Matrix2d S = (Eigen::Matrix2d() << 2, 0.5, 0.5, 1).finished();
  const GaussianScore score = gaussian_score(r, S);
  EXPECT_NEAR(score.chi_square, r.dot(S.inverse() * r), 1e-12);
  EXPECT_NEAR(score.cost,
              0.5 * r.dot(S.inverse() * r) + 0.5 * std::log(4 * M_PI * M_PI * S.determinant()),
              1e-12);
  EXPECT_TRUE(std::isinf(gaussian_score(r, -S).cost));
}

// A landmark straight behind the robot, seen at either side of the cut.
TEST(PredictedSightings, AnglesWrapAtHalfATurn) {
  const SE2 pose({0, 0}, SO2(0.0));
  const Eigen::MatrixXd joint = 0.01 * Eigen::MatrixXd::Identity(5, 5);
  const auto predicted = predict_sightings<SE2>(pose, SE2(), {{-10, 1e-3}}, joint);
  MeasuredPoint measured{Eigen::Vector2d(10, -M_PI + 1e-3), 1e-4 * Eigen::Matrix2d::Identity()};
  EXPECT_NEAR(predicted.innovation(measured.z, 0)[1], 1.1e-3, 1e-6);
  EXPECT_LT(predicted.score(measured, 0).chi_square, 1.0);
  measured.z[1] = M_PI - 1e-3;
  EXPECT_LT(predicted.score(measured, 0).chi_square, 1.0);
}

template <class Pose>
Eigen::VectorXd stacked(const Pose& pose, const Pose& sensor,
                        const std::vector<typename Pose::Point>& points) {
  constexpr int kDim = Pose::Point::RowsAtCompileTime;
  Eigen::VectorXd z(kDim * static_cast<int>(points.size()));
  for (std::size_t j = 0; j < points.size(); ++j) {
    z.template segment<kDim>(kDim * static_cast<int>(j)) =
        SensorView<Pose>(sensor).polar(pose, points[j], nullptr, nullptr);
  }
  return z;
}

/// The covariance must be J joint J' with J by finite differences.
template <class Pose>
void expect_covariance(const Pose& pose, const Pose& sensor,
                       const std::vector<typename Pose::Point>& points, unsigned seed) {
  constexpr int kDim = Pose::Point::RowsAtCompileTime;
  const int n = Pose::kDim + kDim * static_cast<int>(points.size());
  std::srand(seed);
  const Eigen::MatrixXd A = Eigen::MatrixXd::Random(n, n);
  const Eigen::MatrixXd joint = A * A.transpose();
  const auto predicted = predict_sightings<Pose>(pose, sensor, points, joint);
  const Eigen::VectorXd z = stacked(pose, sensor, points);
  Eigen::MatrixXd J(z.size(), n);
  constexpr double kStep = 1e-6;
  for (int k = 0; k < n; ++k) {
    Pose moved_pose = pose;
    auto moved = points;
    if (k < Pose::kDim) {
      typename Pose::Tangent step = Pose::Tangent::Zero();
      step[k] = kStep;
      moved_pose = pose * Pose::exp(step);
    } else {
      moved[(k - Pose::kDim) / kDim][(k - Pose::kDim) % kDim] += kStep;
    }
    J.col(k) = (stacked(moved_pose, sensor, moved) - z) / kStep;
  }
  const Eigen::MatrixXd expected = J * joint * J.transpose();
  EXPECT_LT((predicted.covariance - expected).norm(), 1e-4 * expected.norm());
}

TEST(PredictedSightings, CovarianceIsPropagatedFromTheJointOne) {
  expect_covariance<SE2>(SE2({1, 2}, SO2(0.4)), SE2({0.5, 0.1}, SO2(-0.2)), {{4, 3}, {6, -1}}, 1);
  Eigen::Matrix<double, 6, 1> v;
  v << 1, 2, 3, 0.3, -0.2, 0.5;
  expect_covariance<SE3>(SE3::exp(v), SE3::exp(0.2 * v), {{6, 3, 1}, {7, -1, 4}, {4, 4, 4}}, 2);
}

TEST(PredictedSightings, JointScoreSeesCorrelations) {
  // The heading is poor: both landmarks must be off by the same angle.
  Eigen::MatrixXd joint = 1e-6 * Eigen::MatrixXd::Identity(7, 7);
  joint(2, 2) = 0.04;
  const auto predicted = predict_sightings<SE2>(SE2(), SE2(), {{10, 0}, {0, 10}}, joint);
  const Eigen::Matrix2d noise = 1e-4 * Eigen::Matrix2d::Identity();
  const auto at = [&](double a, double b) {
    return std::vector<MeasuredPoint>{{Eigen::Vector2d(10, a), noise},
                                      {Eigen::Vector2d(10, M_PI_2 + b), noise}};
  };
  const Matching matching{{0, 1}, 0};
  const double same = predicted.score(at(0.2, 0.2), matching).chi_square;
  const double opposite = predicted.score(at(0.2, -0.2), matching).chi_square;
  EXPECT_LT(same, 2.0);
  EXPECT_GT(opposite, 100.0);
}

}  // namespace
}  // namespace hybrid
