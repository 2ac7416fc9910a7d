// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, the hybrid mapping authors
#include "libhybrid/association/joint_compatibility.h"

#include <gtest/gtest.h>

#include <random>

#include "libhybrid/core/chi_square.h"

namespace hybrid {
namespace {

constexpr double kGate = 0.99;

/// Sightings in the plane of landmarks at these ranges ahead, known for certain.
PredictedSightings certain(const std::vector<double>& ranges) {
  PredictedSightings predicted;
  const int n = static_cast<int>(ranges.size());
  predicted.dim = 2;
  predicted.mean.setZero(2, n);
  for (int j = 0; j < n; ++j) predicted.mean(0, j) = ranges[j];
  predicted.covariance = 1e-6 * Eigen::MatrixXd::Identity(2 * n, 2 * n);
  return predicted;
}

MeasuredPoint detection(double range, double sigma) {
  return {Eigen::Vector2d(range, 0.0), sigma * sigma * Eigen::Matrix2d::Identity()};
}

// A camera's far detection is a hundred times less certain than its near one.
TEST(JointCompatibility, UsesTheNoiseOfEveryDetection) {
  const PredictedSightings predicted = certain({5.0, 50.0});
  const MeasuredPoint sharp = detection(5.01, 0.01), vague = detection(51.0, 1.0);
  EXPECT_EQ(joint_compatibility(predicted, {sharp, vague}, kGate).column, (std::vector<int>{0, 1}));
  EXPECT_EQ(joint_compatibility(predicted, {vague, sharp}, kGate).column, (std::vector<int>{1, 0}));
  const MeasuredPoint astray = detection(5.5, 0.01);
  EXPECT_EQ(joint_compatibility(predicted, {astray, vague}, kGate).column,
            (std::vector<int>{-1, 1}));
  EXPECT_EQ(joint_compatibility(predicted, {vague, astray}, kGate).column,
            (std::vector<int>{1, -1}));
}

TEST(JointCompatibility, WrapsAngles) {
  PredictedSightings predicted = certain({5.0});
  predicted.mean(1, 0) = M_PI - 0.01;
  MeasuredPoint z = detection(5.0, 0.02);
  z.z[1] = -M_PI + 0.01;
  EXPECT_EQ(joint_compatibility(predicted, {z}, kGate).column, std::vector<int>{0});
}

TEST(JointCompatibility, OfNothingIsNothing) {
  EXPECT_TRUE(joint_compatibility(certain({5.0}), {}, kGate).column.empty());
  EXPECT_EQ(joint_compatibility(certain({}), {detection(5.0, 0.1)}, kGate).column,
            std::vector<int>{-1});
}

/// All matchings, tried one by one.
class Exhaustive {
 public:
  Exhaustive(const PredictedSightings& predicted, const std::vector<MeasuredPoint>& measured)
      : predicted_(predicted), measured_(measured) {}

  Matching run() {
    now_.column.assign(measured_.size(), -1);
    best_ = now_;
    visit(0, 0);
    return best_;
  }

 private:
  void visit(std::size_t i, int pairs) {
    if (i < measured_.size()) {
      visit(i + 1, pairs);
      for (int j = 0; j < predicted_.mean.cols(); ++j) {
        if (std::count(now_.column.begin(), now_.column.end(), j) > 0) continue;
        if (predicted_.score(measured_[i], j).chi_square > chi_square_quantile(kGate, 2)) continue;
        now_.column[i] = j;
        // Every part of a jointly compatible matching found in this order is compatible too.
        const double chi_square = predicted_.score(measured_, now_).chi_square;
        if (chi_square <= chi_square_quantile(kGate, 2 * (pairs + 1))) visit(i + 1, pairs + 1);
        now_.column[i] = -1;
      }
      return;
    }
    now_.cost = pairs > 0 ? predicted_.score(measured_, now_).chi_square : 0.0;
    if (pairs < most_ || (pairs == most_ && now_.cost >= best_.cost)) return;
    most_ = pairs;
    best_ = now_;
  }

  const PredictedSightings& predicted_;
  const std::vector<MeasuredPoint>& measured_;
  Matching now_, best_;
  int most_ = 0;
};

TEST(JointCompatibility, FindsTheMostPairsOfLeastChiSquare) {
  std::mt19937 rng(5);
  std::normal_distribution<double> normal;
  int ambiguous = 0;
  for (int trial = 0; trial < 200; ++trial) {
    const int landmarks = 1 + trial % 5, detections = 1 + trial % 4;
    PredictedSightings predicted = certain(std::vector<double>(landmarks, 10.0));
    for (double& x : predicted.mean.reshaped()) x += 1.0 * normal(rng);
    const Eigen::MatrixXd A = Eigen::MatrixXd::NullaryExpr(2 * landmarks, 2 * landmarks,
                                                           [&] { return 0.3 * normal(rng); });
    predicted.covariance = A * A.transpose();
    std::vector<MeasuredPoint> measured;
    for (int i = 0; i < detections; ++i) {
      MeasuredPoint z = detection(10.0 + normal(rng), std::exp(normal(rng)) * 0.2);
      z.z[1] = normal(rng);
      measured.push_back(z);
    }
    const Matching expected = Exhaustive(predicted, measured).run();
    const Matching found = joint_compatibility(predicted, measured, kGate);
    EXPECT_EQ(found.column, expected.column) << "trial " << trial;
    EXPECT_NEAR(found.cost, expected.cost, 1e-9);
    ambiguous += std::count(found.column.begin(), found.column.end(), -1) < detections - 1;
  }
  EXPECT_GT(ambiguous, 50);
}

TEST(JointCompatibility, EndsWithTheBestFoundWhereAllIsAmbiguous) {
  const PredictedSightings predicted = certain(std::vector<double>(40, 10.0));
  const std::vector<MeasuredPoint> measured(40, detection(10.0, 1.0));
  const Matching found = joint_compatibility(predicted, measured, kGate, 1000);
  EXPECT_EQ(std::count(found.column.begin(), found.column.end(), -1), 0);
}

}  // namespace
}  // namespace hybrid
