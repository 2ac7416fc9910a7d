// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, the hybrid mapping authors
#include "libhybrid/core/pivoted_cholesky.h"

#include <gtest/gtest.h>

#include <random>

namespace hybrid {
namespace {

TEST(PivotedCholesky, FindsTheRankAndTheMatrix) {
  std::mt19937_64 random(3);
  std::normal_distribution<double> normal;
  for (int n = 1; n <= 12; ++n) {
    for (int rank = 0; rank <= n; ++rank) {
      const Eigen::MatrixXd J =
          Eigen::MatrixXd::NullaryExpr(rank, n, [&](auto, auto) { return normal(random); });
      const Eigen::MatrixXd A = J.transpose() * J;
      const PivotedCholesky factor(A, 1e-10);
      ASSERT_EQ(factor.rank(), rank) << n;
      const Eigen::MatrixXd rebuilt = factor.lower * factor.lower.transpose();
      EXPECT_LT((rebuilt - A(factor.order, factor.order)).norm(), 1e-12 * (1 + A.norm())) << n;
      for (int k = 1; k < rank; ++k) EXPECT_LE(factor.lower(k, k), factor.lower(k - 1, k - 1));
      const Eigen::VectorXd x = J.transpose() * Eigen::VectorXd::Ones(rank);
      const Eigen::VectorXd y = factor.triangle().solve(factor.pivots_of(x));
      EXPECT_NEAR(y.squaredNorm(), rank, 1e-6) << n;  // x' A^+ x
    }
  }
}

TEST(PivotedCholesky, FindsWhatStandsBehindADependentColumn) {
  Eigen::Matrix4d A;
  A << 1, -1, 0, 0,  //
      -1, 1, 0, 0,   //
      0, 0, 1, 0,    //
      0, 0, 0, 0;
  const PivotedCholesky factor(A, 1e-15);
  EXPECT_EQ(factor.rank(), 2);
}

TEST(PivotedCholesky, AnEmptyMatrixHasNoRank) {
  EXPECT_EQ(PivotedCholesky(Eigen::MatrixXd(0, 0), 0).rank(), 0);
}

}  // namespace
}  // namespace hybrid
