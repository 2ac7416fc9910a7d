// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, the hybrid mapping authors
#include "libhybrid/switching/learn.h"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>

#include "libhybrid/core/error.h"
#include "libhybrid/discrete/inference.h"
#include "tests/libhybrid/switching/switching_systems.h"

namespace hybrid {
namespace {

using testing::Random;
using testing::simulate;
using testing::two_modes;

LearnOptions first_order() {
  LearnOptions options;
  options.order = 1;
  return options;
}

void expect_near(const SwitchingModel& found, const SwitchingModel& truth, double tolerance) {
  for (int m = 0; m < truth.modes(); ++m) {
    EXPECT_LT((found.motions[m].coefficients - truth.motions[m].coefficients).cwiseAbs().maxCoeff(),
              tolerance);
    EXPECT_LT((found.motions[m].covariance - truth.motions[m].covariance).cwiseAbs().maxCoeff(),
              0.1 * tolerance);
  }
  EXPECT_LT((found.chain.transition - truth.chain.transition).cwiseAbs().maxCoeff(), tolerance);
}

TEST(LearnFromLabels, RecoversTheModel) {
  Random random(1);
  const SwitchingModel truth = two_modes();
  const SwitchingModel found = learn_from_labels(
      {simulate(truth, 3000, random), simulate(truth, 2000, random)}, 2, first_order());
  expect_near(found, truth, 0.05);
}

TEST(LearnFromLabels, RejectsBadLabels) {
  const Series series = Series::Random(2, 4);
  EXPECT_THROW(learn_from_labels({}, 2), Error);
  EXPECT_THROW(learn_from_labels({{series, {0, 1, 2, 0}}}, 2), Error);
  EXPECT_THROW(learn_from_labels({{series, {0, 1, 0}}}, 2), Error);
  EXPECT_THROW(learn_from_labels({{series, {0, 0, 0, 0}}}, 2), Error);
  EXPECT_THROW(learn_from_labels({{series, {0, 1, 0, 1}}, {Series::Zero(3, 2), {0, 1}}}, 2), Error);
}

TEST(LearnWithoutLabels, NeverLowersThePosteriorAndRecoversTheModel) {
  Random random(2);
  const SwitchingModel truth = two_modes();
  const std::vector<Series> series = {simulate(truth, 1500, random).series,
                                      simulate(truth, 1500, random).series};
  SwitchingModel guess = truth;
  guess.motions[0].coefficients *= 0.5;
  guess.motions[1].coefficients *= 0.3;
  for (Autoregression& motion : guess.motions) motion.covariance *= 3.0;
  guess.chain = sticky_chain(2, 0.6);
  const EmResult result = learn_without_labels(series, guess, first_order());
  EXPECT_TRUE(result.converged);
  ASSERT_GT(result.log_posteriors.size(), 3U);
  for (std::size_t i = 1; i < result.log_posteriors.size(); ++i) {
    EXPECT_GE(result.log_posteriors[i], result.log_posteriors[i - 1] - 1e-7);
  }
  expect_near(result.model, truth, 0.06);
}

TEST(LearnWithoutLabels, GuessSortsByLevel) {
  Series series(1, 90);
  Random random(3);
  for (int t = 0; t < 90; ++t) series(0, t) = (t / 30) * 2.0 - 2.0 + random.normal(0.3);
  const SwitchingModel guess = guess_by_level({series}, 3, 2);
  const EmResult result = learn_without_labels({series}, guess);
  const Labelling found = label(result.model, series);
  int right = 0;
  for (int t = 0; t < 90; ++t) right += found.modes[t] == t / 30;
  EXPECT_GE(right, 86);
}

TEST(TableMarginals, EqualJointMarginals) {
  Random random(8);
  const Series series = simulate(two_modes(0.7), 12, random).series;
  const std::vector<Table> tables = switching_tables(two_modes(0.7), series);
  std::vector<const Table*> factors;
  for (const Table& table : tables) factors.push_back(&table);
  const TableMarginals all = table_marginals(factors);
  ASSERT_EQ(all.tables.size(), tables.size());
  for (std::size_t i = 0; i < tables.size(); ++i) {
    std::vector<Key> keys;
    for (const DiscreteKey& key : tables[i].keys()) keys.push_back(key.key);
    const std::vector<double> expected = joint_marginal(factors, keys);
    ASSERT_EQ(all.tables[i].size(), expected.size());
    for (std::size_t j = 0; j < expected.size(); ++j) {
      EXPECT_NEAR(all.tables[i][j], expected[j], 1e-12);
    }
  }
  EXPECT_NEAR(all.log_partition, discrete_marginals(factors).log_partition(), 1e-10);
}

}  // namespace
}  // namespace hybrid
