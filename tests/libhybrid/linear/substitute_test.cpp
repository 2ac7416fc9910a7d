// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, the hybrid mapping authors
#include "libhybrid/linear/detail/substitute.h"

#include <gtest/gtest.h>

#include <Eigen/Core>

namespace hybrid {
namespace {

TEST(Substitute, ThreeRightHandSidesTogetherGiveTheSameBitsAsOneByOne) {
  constexpr int kHeight = 23, kStride = 26;
  for (int columns = 1; columns <= 9; ++columns) {
    Eigen::MatrixXd panel = Eigen::MatrixXd::Random(kStride, columns);
    for (int j = 0; j < columns; ++j) panel(j, j) = 2.0 + j;
    const Eigen::MatrixXd start = Eigen::MatrixXd::Random(kHeight, 3);
    Eigen::MatrixXd one = start, three = start;
    for (int d = 0; d < 3; ++d) {
      substitute(panel.data(), kStride, kHeight, columns, one.col(d).data());
    }
    substitute3(panel.data(), kStride, kHeight, columns, three.data());
    EXPECT_EQ(one, three) << columns;
    const Eigen::MatrixXd top = panel.topRows(columns).triangularView<Eigen::Lower>();
    EXPECT_LT((top * three.topRows(columns) - start.topRows(columns)).norm(), 1e-12);
    const auto below = panel.middleRows(columns, kHeight - columns);
    EXPECT_LT((three.bottomRows(kHeight - columns) + below * three.topRows(columns) -
               start.bottomRows(kHeight - columns))
                  .norm(),
              1e-12);
  }
}

}  // namespace
}  // namespace hybrid
