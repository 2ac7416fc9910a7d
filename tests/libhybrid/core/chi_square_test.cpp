// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, the hybrid mapping authors
#include "libhybrid/core/chi_square.h"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>

#include "libhybrid/core/error.h"

namespace hybrid {
namespace {

TEST(ChiSquare, QuantilesOfTheTables) {
  EXPECT_NEAR(chi_square_quantile(0.95, 1), 3.841458820694124, 1e-9);
  EXPECT_NEAR(chi_square_quantile(0.99, 3), 11.344866730144373, 1e-9);
  EXPECT_NEAR(chi_square_quantile(0.99, 6), 16.811893829770927, 1e-9);
  EXPECT_NEAR(chi_square_quantile(0.5, 2), 2.0 * std::log(2.0), 1e-12);
  EXPECT_NEAR(chi_square_quantile(0.01, 10), 2.558212160187197, 1e-9);
  EXPECT_DOUBLE_EQ(chi_square_quantile(0.0, 4), 0.0);
}

TEST(ChiSquare, ProbabilityIsTheInverseOfTheQuantile) {
  for (int degrees : {1, 2, 3, 6, 7, 40}) {
    for (double p : {1e-6, 0.1, 0.5, 0.9, 0.99999}) {
      EXPECT_NEAR(chi_square_probability(chi_square_quantile(p, degrees), degrees), p, 1e-12);
    }
  }
  EXPECT_DOUBLE_EQ(chi_square_probability(-1.0, 3), 0.0);
}

TEST(ChiSquare, RefusesWhatIsNoProbability) {
  EXPECT_THROW(chi_square_quantile(1.0, 3), Error);
  EXPECT_THROW(chi_square_quantile(-0.1, 3), Error);
  EXPECT_THROW(chi_square_quantile(std::numeric_limits<double>::quiet_NaN(), 3), Error);
  EXPECT_THROW(chi_square_quantile(0.5, 0), Error);
  EXPECT_THROW(chi_square_probability(std::numeric_limits<double>::quiet_NaN(), 1), Error);
}

}  // namespace
}  // namespace hybrid
