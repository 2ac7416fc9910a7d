// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, the hybrid mapping authors
#include "libhybrid/linear/detail/substitute.h"

#include <gtest/gtest.h>

#include <Eigen/Core>

namespace hybrid {
namespace {

TEST(Substitute, IsTheTriangularSolveAndItsUpdate) {
  std::srand(3);
  for (const int columns : {1, 2, 3, 4, 5, 8, 11}) {
    for (const int below : {0, 1, 6}) {
      const int height = columns + below;
      Eigen::MatrixXd L = Eigen::MatrixXd::Random(height + 2, columns);  // two rows of padding
      L.diagonal().array() += 3.0;
      Eigen::VectorXd w = Eigen::VectorXd::Random(height + 1);
      const double behind = w[height];
      Eigen::VectorXd x = w.head(columns);
      L.topRows(columns).triangularView<Eigen::Lower>().solveInPlace(x);
      const Eigen::VectorXd rest = w.segment(columns, below) - L.middleRows(columns, below) * x;
      substitute(L.data(), height + 2, height, columns, w.data());
      EXPECT_LT((w.head(columns) - x).norm(), 1e-12) << columns << ' ' << below;
      EXPECT_LT((w.segment(columns, below) - rest).norm(), 1e-12) << columns << ' ' << below;
      EXPECT_EQ(w[height], behind);
    }
  }
}

}  // namespace
}  // namespace hybrid
