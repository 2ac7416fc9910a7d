// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, the hybrid mapping authors

#include <gtest/gtest.h>

#include <Eigen/Dense>
#include <cmath>
#include <random>
#include <stdexcept>

#include "mrpt_plugins/evaluation/landmark_metrics.h"
#include "mrpt_plugins/evaluation/reliability.h"
#include "mrpt_plugins/evaluation/trajectory_metrics.h"

namespace hybrid {
namespace {

using mrpt::poses::CPose3D;

constexpr double kDegree = M_PI / 180;

std::vector<PosePair> random_walk(bool planar, const CPose3D& T_estimate_truth) {
  std::mt19937 random(5);
  std::normal_distribution<double> normal;
  std::vector<PosePair> pairs;
  for (int i = 0; i < 40; ++i) {
    const double x = normal(random);
    const double y = normal(random);
    const double yaw = normal(random);
    const CPose3D truth = planar ? CPose3D(x, y, 0, yaw, 0, 0)
                                 : CPose3D(x, y, normal(random), yaw, normal(random), 0.3);
    pairs.push_back({T_estimate_truth + truth, truth});
  }
  return pairs;
}

TEST(TrajectoryMetrics, HandComputedErrors) {
  const std::vector<PosePair> pairs = {
      {CPose3D(3, 4, 0, 0, 0, 0), CPose3D(0, 0, 0, 30 * kDegree, 0, 0)},
      {CPose3D(1, 1, 1, 0, 0, 0), CPose3D(1, 1, 2, 0, 0, -40 * kDegree)}};
  const TrajectoryErrors e = trajectory_errors(pairs);
  EXPECT_DOUBLE_EQ(e.mean_m, 3);
  EXPECT_DOUBLE_EQ(e.rmse_m, std::sqrt(13.0));
  EXPECT_DOUBLE_EQ(e.max_m, 5);
  EXPECT_NEAR(e.rotation_mean_deg, 35, 1e-9);
  EXPECT_NEAR(e.rotation_rmse_deg, std::sqrt((900 + 1600) / 2.0), 1e-9);
  EXPECT_TRUE(std::isnan(trajectory_errors({}).mean_m));
}

TEST(TrajectoryMetrics, AlignmentRecoversARigidMotion) {
  const CPose3D motions[] = {CPose3D(5, -3, 0, 2.5, 0, 0), CPose3D(-1, 2, 7, -2.0, 1.0, 3.0)};
  for (const bool planar : {true, false}) {
    const CPose3D& motion = motions[planar ? 0 : 1];
    const auto pairs = random_walk(planar, motion);
    EXPECT_LT((alignment(pairs) + motion).norm(), 1e-12);
    const TrajectoryReport r = trajectory_report(pairs);
    EXPECT_GT(r.unaligned.mean_m, 1);
    EXPECT_LT(r.aligned.max_m, 1e-12);
    EXPECT_LT(r.aligned.rotation_rmse_deg, 1e-6);
    EXPECT_EQ(r.poses, pairs.size());
    EXPECT_TRUE(r.is_telling());
    EXPECT_FALSE(trajectory_report({pairs[0], pairs[1]}).is_telling());
  }
}

TEST(TrajectoryMetrics, AMirroredPathIsNotAlignedByAReflection) {
  for (const bool planar : {true, false}) {
    auto pairs = random_walk(planar, CPose3D());
    for (PosePair& p : pairs) p.estimate.y(-p.estimate.y());
    const CPose3D T = alignment(pairs);
    EXPECT_NEAR(T.getRotationMatrix().det(), 1, 1e-9);
    EXPECT_GT(trajectory_report(pairs).aligned.mean_m, 0.1);
    if (planar) {
      EXPECT_DOUBLE_EQ(T.getRotationMatrix()(2, 2), 1);
    }
  }
}

TEST(TrajectoryMetrics, AlignmentSurvivesAStraightPathAndAStandstill) {
  std::vector<PosePair> straight;
  for (int i = 0; i < 5; ++i)
    straight.push_back({CPose3D(0, i, 0, M_PI / 2, 0, 0), CPose3D(i, 0, 0, 0, 0, 0)});
  const TrajectoryReport r = trajectory_report(straight);
  EXPECT_LT(r.aligned.max_m, 1e-12);
  EXPECT_LT(r.aligned.rotation_mean_deg, 1e-6);
  const std::vector<PosePair> still(3, {CPose3D(1, 2, 3, 0, 0, 0), CPose3D(4, 5, 6, 0, 0, 0)});
  EXPECT_LT(trajectory_report(still).aligned.max_m, 1e-12);
}

TEST(TrajectoryMetrics, AlignedErrorsDoNotDependOnTheFrame) {
  auto pairs = random_walk(false, CPose3D());
  for (std::size_t i = 0; i < pairs.size(); ++i) pairs[i].estimate.x_incr(0.1 * std::sin(3.0 * i));
  const double before = trajectory_report(pairs).aligned.rmse_m;
  for (PosePair& p : pairs) p.estimate = CPose3D(4, 5, 6, 1, 0.5, -2) + p.estimate;
  EXPECT_GT(before, 0.01);
  EXPECT_NEAR(trajectory_report(pairs).aligned.rmse_m, before, 1e-12);
}

TEST(TrajectoryMetrics, PairsByNearestTime) {
  const Trajectory truth = {{10, CPose3D(1, 0, 0, 0, 0, 0)}, {20, CPose3D(2, 0, 0, 0, 0, 0)}};
  const Trajectory estimate = {{5, {}}, {9, {}}, {14, {}}, {16, {}}, {22, {}}, {30, {}}};
  const auto pairs = pair_by_time(estimate, truth, 4.5);
  ASSERT_EQ(pairs.size(), 4u);
  EXPECT_EQ(pairs[0].truth.x(), 1);
  EXPECT_EQ(pairs[1].truth.x(), 1);
  EXPECT_EQ(pairs[2].truth.x(), 2);
  EXPECT_EQ(pairs[3].truth.x(), 2);
  EXPECT_TRUE(pair_by_time(estimate, {}, 100).empty());
}

TEST(TrajectoryMetrics, RelativeErrorsOfAConstantDrift) {
  std::vector<PosePair> pairs;
  for (int i = 0; i <= 10; ++i) {
    pairs.push_back({CPose3D(1.1 * i, 0, 0, 0, 0, 0), CPose3D(i, 0, 0, 0, 0, 0)});
  }
  const auto errors = relative_errors(pairs, {2, 5, 100});
  ASSERT_EQ(errors.size(), 3u);
  EXPECT_EQ(errors[0].stretches, 9u);
  EXPECT_NEAR(errors[0].translation_m, 0.2, 1e-12);
  EXPECT_EQ(errors[1].stretches, 6u);
  EXPECT_NEAR(errors[1].translation_m, 0.5, 1e-12);
  EXPECT_NEAR(errors[1].rotation_deg, 0, 1e-9);
  EXPECT_EQ(errors[2].stretches, 0u);
  EXPECT_TRUE(std::isnan(errors[2].translation_m));
}

TEST(TrajectoryMetrics, TangentErrorIsTheGroupLogarithm) {
  // A quarter turn of radius 1 is exp of (pi/2 forward, pi/2 yaw).
  const auto e = tangent_error({CPose3D(), CPose3D(1, 1, 0, M_PI / 2, 0, 0)});
  Eigen::Matrix<double, 6, 1> expected;
  expected << M_PI / 2, 0, 0, 0, 0, M_PI / 2;
  EXPECT_LT((e - expected).norm(), 1e-12);
  const auto small = tangent_error({CPose3D(), CPose3D(1, 2, 3, 1e-6, 0, 0)});
  EXPECT_NEAR(small[0], 1 + 1e-6, 1e-10);
  EXPECT_NEAR(small[1], 2 - 0.5e-6, 1e-10);
}

TEST(TrajectoryMetrics, NeesOfAnHonestCovarianceIsOne) {
  std::mt19937 random(7);
  std::normal_distribution<double> normal;
  std::vector<PosePair> pairs;
  std::vector<Eigen::MatrixXd> planar;
  for (int i = 0; i < 4000; ++i) {
    const CPose3D truth(i, 1, 0, 0.1 * i, 0, 0);
    const CPose3D noise(0.01 * normal(random), 0.02 * normal(random), 0, 0.003 * normal(random), 0,
                        0);
    pairs.push_back({truth + noise, truth});
    planar.emplace_back(Eigen::Vector3d(1e-4, 4e-4, 9e-6).asDiagonal());
  }
  EXPECT_NEAR(mean_nees(pairs, planar), 1, 0.04);
  planar.pop_back();
  EXPECT_THROW(mean_nees(pairs, planar), std::invalid_argument);
  EXPECT_THROW(mean_nees({pairs[0]}, {Eigen::MatrixXd::Identity(2, 2)}), std::invalid_argument);
  const PosePair one{CPose3D(), CPose3D(0, 0, 2, 0, 0, 0)};
  EXPECT_NEAR(mean_nees({one}, {Eigen::MatrixXd::Identity(6, 6) * 0.5}), 4 / 0.5 / 6, 1e-12);
}

LandmarkEstimate estimate_at(std::int64_t id, double x, double y, int class_index = 0) {
  LandmarkEstimate l;
  l.id = id;
  l.position = {x, y, 0};
  l.class_index = class_index;
  return l;
}

TEST(LandmarkMetrics, ById) {
  const std::vector<LandmarkEstimate> estimates = {estimate_at(2, 3, 4), estimate_at(1, 0, 1),
                                                   estimate_at(2, 9, 9), estimate_at(8, 0, 0)};
  const std::vector<TrueLandmark> truth = {
      {1, {0, 0, 0}, 0}, {2, {0, 0, 0}, 1}, {5, {0, 0, 0}, {}}};
  const LandmarkMatching m = match_by_id(estimates, truth);
  EXPECT_EQ(m, (LandmarkMatching{{0, 1}, {1, 0}}));
  const LandmarkErrors e = landmark_errors(m, estimates, truth);
  EXPECT_EQ(e.matched, 2u);
  EXPECT_EQ(e.spurious, 2u);
  EXPECT_EQ(e.missed, 1u);
  EXPECT_DOUBLE_EQ(e.mean_m, 3);
  EXPECT_DOUBLE_EQ(e.max_m, 5);
  EXPECT_DOUBLE_EQ(class_accuracy(m, estimates, truth).value(), 0.5);
  EXPECT_FALSE(class_accuracy({}, estimates, truth).has_value());
  std::vector<LandmarkEstimate> nameless = estimates;
  for (LandmarkEstimate& l : nameless) l.class_index.reset();
  EXPECT_FALSE(class_accuracy(m, nameless, truth).has_value());
  EXPECT_TRUE(std::isnan(landmark_errors({}, estimates, truth).mean_m));
}

TEST(LandmarkMetrics, ByDistanceIsOneToOneAndNearestFirst) {
  const std::vector<LandmarkEstimate> estimates = {estimate_at(10, 0.4, 0), estimate_at(11, 0.9, 0),
                                                   estimate_at(12, 50, 0)};
  const std::vector<TrueLandmark> truth = {
      {1, {1, 0, 0}, {}}, {2, {0, 0, 0}, {}}, {3, {0, 9, 0}, {}}};
  EXPECT_EQ(match_by_distance(estimates, truth, 1.0), (LandmarkMatching{{0, 1}, {1, 0}}));
  EXPECT_EQ(match_by_distance(estimates, truth, 0.3), (LandmarkMatching{{1, 0}}));
}

TEST(LandmarkMetrics, AssociationsAreJudgedByWhatMostMeasurementsOfALandmarkSaw) {
  // Landmark 10 stands for 1 (three of its four), 12 for 2; 11 is a second copy of 1.
  const std::vector<AssociationDecision> decisions = {
      {10, 1}, {10, 1}, {10, 1}, {10, 2}, {11, 1}, {11, 1}, {12, 2}, {{}, 2}, {{}, {}}, {10, {}}};
  const AssociationReport report = association_report(decisions);
  EXPECT_EQ(report.labelled, 8u);
  EXPECT_EQ(report.right, 4u);
  EXPECT_EQ(report.rejected, 1u);
  EXPECT_EQ(report.unlabelled, 2u);
  EXPECT_EQ(report.unlabelled_rejected, 1u);
  EXPECT_DOUBLE_EQ(report.accuracy(), 0.5);
  EXPECT_EQ(association_report({}).labelled, 0u);
}

TEST(LandmarkMetrics, NeesIsOneWhereErrorsAreAsLargeAsClaimed) {
  LandmarkEstimate estimate;
  estimate.position = {1.1, 1.8, 0};
  estimate.covariance = Eigen::Vector3d(0.01, 0.04, 0).asDiagonal();
  const std::vector<TrueLandmark> truth = {{4, {1, 2, 0}, {}}};
  EXPECT_NEAR(landmark_nees({{0, 0}}, {estimate}, truth).value(), 1.0, 1e-9);
  estimate.covariance.setZero();  // not known
  EXPECT_FALSE(landmark_nees({{0, 0}}, {estimate}, truth));
}

TEST(Calibration, HandComputedFigures) {
  const Calibration c = calibration({{{0.75, 0.25}, 0}, {{0.75, 0.25}, 1}}, 2);
  EXPECT_DOUBLE_EQ(c.brier, 0.5 * (0.125 + 1.125));
  EXPECT_DOUBLE_EQ(c.log_loss, -0.5 * (std::log(0.75) + std::log(0.25)));
  ASSERT_EQ(c.bins.size(), 2u);
  EXPECT_EQ(c.bins[0].count, 2u);
  EXPECT_DOUBLE_EQ(c.bins[0].mean_predicted, 0.25);
  EXPECT_DOUBLE_EQ(c.bins[0].observed, 0.5);
  EXPECT_DOUBLE_EQ(c.bins[1].mean_predicted, 0.75);
  EXPECT_DOUBLE_EQ(c.expected_error, 0.25);
}

TEST(Calibration, EdgesAndErrors) {
  const Calibration sure = calibration({{{1.0, 0.0}, 0}});
  EXPECT_EQ(sure.bins.back().count, 1u);
  EXPECT_EQ(sure.bins.front().count, 1u);
  EXPECT_EQ(sure.brier, 0);
  EXPECT_NEAR(calibration({{{1.0, 0.0}, 1}}).log_loss, -std::log(1e-15), 1e-9);
  EXPECT_TRUE(std::isnan(calibration({}).brier));
  EXPECT_THROW(calibration({{{1.0}, 1}}), std::invalid_argument);
  EXPECT_THROW(calibration({{{std::nan(""), 1.0}, 1}}), std::invalid_argument);
  EXPECT_THROW(calibration({}, 0), std::invalid_argument);
}

TEST(Calibration, HonestProbabilitiesLieOnTheDiagonal) {
  std::mt19937 random(3);
  std::uniform_real_distribution<double> uniform;
  std::vector<ClassPrediction> predictions;
  for (int i = 0; i < 20000; ++i) {
    const double p = uniform(random);
    predictions.push_back({{p, 1 - p}, uniform(random) < p ? 0 : 1});
  }
  for (const ReliabilityBin& bin : calibration(predictions).bins) {
    EXPECT_NEAR(bin.observed, bin.mean_predicted, 0.04);
  }
}

}  // namespace
}  // namespace hybrid
