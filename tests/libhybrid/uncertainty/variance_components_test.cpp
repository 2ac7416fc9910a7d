// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, the hybrid mapping authors
#include "libhybrid/uncertainty/detail/variance_components.h"

#include <gtest/gtest.h>

#include <random>

namespace hybrid {
namespace {

/// Residuals of variance 0.5 + 2 t for t in [0, 3], of which some are outliers.
std::vector<VarianceRow> rows(double outliers) {
  std::mt19937 random(3);
  std::normal_distribution<double> normal;
  std::uniform_real_distribution<double> uniform(0, 1);
  std::vector<VarianceRow> out;
  for (int i = 0; i < 5000; ++i) {
    VarianceRow row;
    const double t = 3 * uniform(random);
    row.shares[0] = 1;
    row.shares[1] = t;
    double e = std::sqrt(0.5 + 2 * t) * normal(random);
    if (uniform(random) < outliers) e = 100;
    row.square = e * e;
    row.part = i % 10;
    out.push_back(row);
  }
  return out;
}

TEST(VarianceComponents, AreFoundAndOutliersBounded) {
  for (const double outliers : {0.0, 0.01}) {
    const Components found = fit_variances(rows(outliers), Components::Ones());
    EXPECT_NEAR(found[0], 0.5, 0.15) << outliers;
    EXPECT_NEAR(found[1], 2.0, 0.3) << outliers;
    EXPECT_EQ(found[2], 1);  // no row has it
  }
}

TEST(VarianceComponents, NoneIsNegative) {
  std::vector<VarianceRow> constant = rows(0);
  for (VarianceRow& row : constant) row.square = 1 / (0.5 + row.shares[1]);
  const Components found = fit_variances(constant, Components::Ones());
  EXPECT_GE(found.minCoeff(), 0);
  EXPECT_LT(found[1], 0.1);
}

TEST(VarianceComponents, APartIsLeftOut) {
  std::vector<VarianceRow> odd = rows(0);
  for (VarianceRow& row : odd) {
    if (row.part == 3) row.square *= 100;
  }
  const Components with = fit_variances(odd, Components::Ones());
  const Components without = fit_variances(odd, Components::Ones(), 3);
  EXPECT_GT(with.head<2>().sum(), 1.2 * without.head<2>().sum());
}

}  // namespace
}  // namespace hybrid
