// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, the hybrid mapping authors

#include "libhybrid/maps/sparse_gaussian.h"

#include <gtest/gtest.h>

#include <Eigen/LU>

#include "libhybrid/core/error.h"
#include "libhybrid/detections/sighting.h"
#include "tests/libhybrid/maps/stored_maps.h"

namespace hybrid {
namespace {

/// KL(p || q) of two Gaussians with one mean.
double divergence(const Eigen::MatrixXd& p, const Eigen::MatrixXd& q) {
  const auto log_det = [](const Eigen::MatrixXd& C) {
    return 2 * Eigen::LLT<Eigen::MatrixXd>(C).matrixLLT().diagonal().array().log().sum();
  };
  return 0.5 *
         ((q.inverse() * p).trace() - static_cast<double>(p.rows()) + log_det(q) - log_det(p));
}

TEST(SparseGaussian, HoldsFewLandmarksExactly) {
  const Eigen::MatrixXd C = drifting_covariance(5, 3, 0.1, 0.5);
  const SparseGaussian sparse = sparsify(C, 3);
  EXPECT_LT((sparse.covariance() - C).norm(), 1e-9 * C.norm());
  EXPECT_NEAR(sparse.loss, 0, 1e-9);
}

TEST(SparseGaussian, SaysWhatIsLost) {
  std::mt19937_64 random(7);
  std::normal_distribution<double> normal;
  Eigen::MatrixXd A(60, 60);
  for (double& v : A.reshaped()) v = normal(random);
  const Eigen::MatrixXd C = A * A.transpose() + Eigen::MatrixXd::Identity(60, 60);
  const SparseGaussian sparse = sparsify(C, 2, 1e9);
  EXPECT_GT(sparse.loss, 0.1);
  EXPECT_NEAR(sparse.loss, divergence(C, sparse.covariance()), 1e-6 * sparse.loss);
  std::size_t most = 0;
  for (const SparseRow& row : sparse.rows) most = std::max(most, row.variables.size());
  EXPECT_EQ(most, 5u);
}

TEST(SparseGaussian, LosesNoMoreThanItMay) {
  const Eigen::MatrixXd C = drifting_covariance(80, 2, 0.2, 0.3);
  const SparseGaussian sparse = sparsify(C, 2, 0.1);
  EXPECT_LE(sparse.loss, 0.1);
  EXPECT_NEAR(sparse.loss, divergence(C, sparse.covariance()), 1e-6);
}

TEST(SparseGaussian, KnowsEachLandmarkAlone) {
  std::mt19937_64 random(7);
  std::normal_distribution<double> normal;
  Eigen::MatrixXd A(120, 120);
  for (double& v : A.reshaped()) v = normal(random);
  const SparseGaussian sparse =
      sparsify(A * A.transpose() + Eigen::MatrixXd::Identity(120, 120), 3, 1e9);
  const Eigen::MatrixXd C = sparse.covariance();
  const auto alone = sparse.covariances();
  ASSERT_EQ(alone.size(), 40U);
  for (int i = 0; i < 40; ++i) {
    EXPECT_LT((alone[static_cast<std::size_t>(i)] - C.block<3, 3>(3 * i, 3 * i)).norm(),
              1e-9 * C.norm());
  }
}

TEST(SparseGaussian, LandmarksAloneNeedNoJointCovariance) {
  SparseGaussian walk;  // of which the joint covariance would have 13 GB
  for (int i = 0; i < 20000; ++i) {
    SparseRow row;
    row.variables = {i};
    row.R = Eigen::MatrixXd::Identity(2, 2);
    if (i > 0) {
      row.variables.push_back(i - 1);
      row.R.conservativeResize(2, 4);
      row.R.rightCols(2) = -Eigen::Matrix2d::Identity();
    }
    walk.rows.push_back(row);
  }
  EXPECT_NEAR(walk.covariances().back()(0, 0), 20000, 1e-6);
}

TEST(SparseGaussian, RefusesWhatIsNoCovariance) {
  EXPECT_THROW(sparsify(-Eigen::MatrixXd::Identity(4, 4), 2), Error);
}

TEST(KnownMap, ItsPriorIsTheJointDensity) {
  std::mt19937_64 random(3);
  const MapRecord map =
      stored_map(scattered(12, 20, false, random), motion(1, 2, 0.3), false, 0.1, 0.2, random);
  const KnownMap known = known_map(map);
  Values values;
  Eigen::VectorXd off(24);
  std::normal_distribution<double> normal;
  for (double& v : off) v = normal(random);
  for (std::size_t i = 0; i < map.landmarks.size(); ++i) {
    const Eigen::Vector2d p =
        map.landmarks[i].position.head<2>() + off.segment<2>(2 * static_cast<Eigen::Index>(i));
    values.insert(position_key(map.landmarks[i].id), p);
  }
  double cost = 0;
  for (const ContinuousFactorPtr& factor : known.prior) cost += factor->cost(values);
  EXPECT_NEAR(cost, 0.5 * off.dot(joint_covariance(map).inverse() * off), 1e-6 * cost);
}

}  // namespace
}  // namespace hybrid
