// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, the hybrid mapping authors

#include "mrpt_plugins/mapping/batch_backend.h"

#include <gtest/gtest.h>

#include "libhybrid/factors/between.h"
#include "libhybrid/factors/prior.h"
#include "libhybrid/factors/range.h"
#include "tests/support/hard_factors.h"

namespace hybrid {
namespace {

using Eigen::Vector2d;

const Key kX0('x', 0), kX1('x', 1), kL('l', 0);

Delta valley() {
  Delta delta;
  delta.values.insert(kX0, Vector2d(-1.2, 1));
  delta.continuous = {std::make_shared<testing::Valley>(kX0)};
  return delta;
}

TEST(BatchBackend, WarnsWhereItDidNotConverge) {
  AlternatingOptions options;
  options.max_iterations = 1;
  options.continuous_iterations = 3;
  BatchBackend hasty(options, 0);
  hasty.update(valley());
  const BackendReport report = hasty.finish();
  EXPECT_GT(report.cost, 1e-3);
  ASSERT_EQ(report.warnings.size(), 1u);
  EXPECT_NE(report.warnings[0].find("did not converge"), std::string::npos);

  BatchBackend patient({}, 0);
  patient.update(valley());
  EXPECT_TRUE(patient.finish().warnings.empty());
}

TEST(BatchBackend, WarnsOfWhatIsNotDeterminedAndNamesIt) {
  BatchBackend backend({}, 0);
  Delta delta;
  delta.values.insert(kX0, SE2());
  delta.values.insert(kX1, SE2(3, 2, 1));
  delta.continuous = {std::make_shared<BetweenSE2>(kX0, kX1, SE2(1, 0, 0), Noise::unit(3))};
  backend.update(delta);
  const BackendReport report = backend.finish();
  ASSERT_EQ(report.warnings.size(), 1u);
  EXPECT_NE(report.warnings[0].find("x1"), std::string::npos) << report.warnings[0];
  EXPECT_TRUE(backend.uncertainty({kX0, kX1}, {}).covariances.empty());
}

TEST(BatchBackend, LeavesOutTheCovarianceOfWhatIsNotDeterminedOrMeasured) {
  BatchBackend backend({}, 0);
  Delta delta;
  delta.values.insert(kX0, Vector2d(0, 0));
  delta.values.insert(kX1, Vector2d(5, 5));  // in no factor
  delta.values.insert(kL, Vector2d(1, 0));
  delta.continuous = {
      std::make_shared<Prior<Vector2d>>(kX0, Vector2d(0, 0), Noise::isotropic(2, 0.1)),
      std::make_shared<Range<Vector2d, Vector2d>>(kX0, kL, 1.0, Noise::isotropic(1, 0.1))};
  backend.update(delta);
  backend.finish();
  const Uncertainty uncertainty = backend.uncertainty({kX0, kX1, kL}, {});
  ASSERT_EQ(uncertainty.covariances.size(), 1u);
  EXPECT_NEAR(uncertainty.covariances.at(kX0)(0, 0), 0.01, 1e-9);
}

double cost_after(const std::string& linear_solves) {
  IniFile ini("[solver]\nmode = batch\nmax_iterations = 1\nlinear_solves = " + linear_solves,
              "test.ini");
  const auto backend = make_backend(ini.section("solver"));
  backend->update(valley());
  return backend->finish().cost;
}

TEST(BatchBackend, ObeysTheLimitOfLinearSolves) {
  EXPECT_GT(cost_after("2"), cost_after("8"));
  EXPECT_GT(cost_after("8"), 1e-6);
  EXPECT_LT(cost_after("1000"), 1e-12);
}

}  // namespace
}  // namespace hybrid
