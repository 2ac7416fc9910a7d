// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, the hybrid mapping authors

#include "mrpt_plugins/experiment/statistics.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include "libhybrid/core/error.h"
#include "mrpt_plugins/experiment/plots.h"
#include "mrpt_plugins/experiment/pose_graph_trial.h"
#include "tests/support/scratch_folder.h"

namespace hybrid {
namespace {

TEST(Quartiles, InterpolateBetweenValues) {
  const Quartiles q = quartiles({4, 1, 3, 2, 5});
  EXPECT_EQ(q.q1, 2);
  EXPECT_EQ(q.median, 3);
  EXPECT_EQ(q.q3, 4);
  EXPECT_EQ(quartiles({1, 2}).median, 1.5);
  EXPECT_EQ(quartiles({7}).q1, 7);
  EXPECT_TRUE(std::isnan(quartiles({}).median));
  const double infinity = std::numeric_limits<double>::infinity();
  EXPECT_EQ(quartiles({1, 2, infinity}).median, 2);
  EXPECT_EQ(quartiles({1, 2, infinity}).q3, infinity);
  EXPECT_EQ(quartiles({1, infinity, infinity}).median, infinity);
  EXPECT_EQ(quartiles({-infinity, 1, 2}).median, 1);
}

TEST(Reliability, TextsAddUp) {
  ReliabilitySum sum;
  sum.add(reliability_text({0.05, 0.95, 1.0, 0.97}, {false, true, true, false}), 0.2, 0.3);
  sum.add("", 9, 9);
  sum.add(reliability_text({0.5}, {true}), 0.7, 0.8);
  const Calibration c = sum.calibration();
  EXPECT_EQ(c.predictions, 5u);
  EXPECT_NEAR(c.brier, (4 * 0.2 + 0.7) / 5, 1e-12);
  EXPECT_NEAR(c.log_loss, (4 * 0.3 + 0.8) / 5, 1e-12);
  ASSERT_EQ(c.bins.size(), 10u);
  EXPECT_EQ(c.bins[9].count, 3u);
  EXPECT_NEAR(c.bins[9].observed, 2.0 / 3.0, 1e-12);
  EXPECT_NEAR(c.bins[9].mean_predicted, 2.92 / 3.0, 1e-6);
  EXPECT_TRUE(std::isnan(c.bins[3].observed));
  EXPECT_NEAR(c.expected_error, (0.05 + std::abs(2.0 - 2.92) + 0.5) / 5, 1e-6);
  EXPECT_THROW(sum.add("1/2", 0, 0), Error);
}

class StatisticsTest : public ScratchFolder {};

TEST_F(StatisticsTest, SummarizesPoints) {
  ExperimentPlan plan;
  plan.title = "test";
  GraphPlan graph;
  graph.name = "g";
  graph.variants = {""};
  plan.graphs = {graph};
  plan.methods = {"lm", "gnc"};
  plan.outlier_rates = {0.0, 0.5};
  plan.trials = 3;
  Ledger ledger(folder, pose_graph_metrics());
  for (const Trial& trial : trials_of(plan)) {
    if (trial.method == "gnc" && trial.seed == 3) continue;  // not run yet
    TrialResult result;
    if (trial.method == "lm" && trial.seed == 2) {
      result.status = "timeout";
    } else {
      result.metrics["ate_mean_m"] = 0.05 * static_cast<double>(trial.seed);
    }
    result.metrics["cpu_s"] = 1;
    ledger.append(trial, result);
  }
  const auto points = summarize(plan, ledger);
  ASSERT_EQ(points.size(), 4u);
  const PointSummary& lm = points[2];
  EXPECT_EQ(lm.outlier_rate, 0.5);
  EXPECT_EQ(lm.trials, 3u);
  EXPECT_EQ(lm.measured, 2u);
  EXPECT_NEAR(lm.success, 1.0 / 3.0, 1e-12);  // 0.05 m; 0.15 m and the timeout are none
  const auto metric = [&](const PointSummary& point, const std::string& name) {
    const auto& names = ledger.metrics();
    return point.metrics.at(std::find(names.begin(), names.end(), name) - names.begin());
  };
  // 0.05 and 0.15 m, and a trial that counts as worse than both.
  EXPECT_NEAR(metric(lm, "ate_mean_m").median, 0.15, 1e-12);
  EXPECT_EQ(metric(lm, "ate_mean_m").q3, std::numeric_limits<double>::infinity());
  EXPECT_EQ(metric(lm, "cpu_s").median, 1);
  EXPECT_EQ(points[3].trials, 2u);
  const std::string csv = summary_csv(points, ledger.metrics());
  EXPECT_NE(csv.find("g,,lm,0.5,3,2,0.33"), std::string::npos) << csv;
  const std::string table = summary_table(plan, points, ledger.metrics());
  EXPECT_NE(table.find("2 of 3"), std::string::npos) << table;
  const Image image = comparison_image(plan, "g", points, ledger.metrics());
  EXPECT_EQ(image.rgb.size(), std::size_t(3) * image.width * image.height);
  EXPECT_THROW(comparison_image(plan, "h", points, ledger.metrics()), std::invalid_argument);
}

// An algorithm that dies on the hard logs must not look better than one that solves them badly.
TEST_F(StatisticsTest, AnAlgorithmThatFailsIsNoBetterThanOneThatSolvesBadly) {
  ExperimentPlan plan;
  plan.title = "test";
  GraphPlan graph;
  graph.name = "g";
  graph.variants = {""};
  plan.graphs = {graph};
  plan.methods = {"steady", "fragile"};
  plan.outlier_rates = {0.5};
  plan.trials = 5;
  Ledger ledger(folder, pose_graph_metrics());
  for (const Trial& trial : trials_of(plan)) {
    TrialResult result;
    const bool hard = trial.seed % 5 < 3;
    if (hard && trial.method == "fragile") {
      result.status = "crashed";
    } else {
      result.metrics["ate_mean_m"] = hard ? 2.0 : 0.01;
      result.metrics["precision"] = hard ? 0.5 : 1.0;
    }
    ledger.append(trial, result);
  }
  const auto points = summarize(plan, ledger);
  ASSERT_EQ(points.size(), 2u);
  const auto& names = ledger.metrics();
  for (const char* name : {"ate_mean_m", "precision"}) {
    const auto m = std::find(names.begin(), names.end(), name) - names.begin();
    const double steady = points[0].metrics[m].median, fragile = points[1].metrics[m].median;
    EXPECT_TRUE(std::isinf(fragile)) << name;
    EXPECT_EQ(fragile > steady, name == std::string("ate_mean_m")) << name;
  }
  EXPECT_NE(summary_table(plan, points, names).find("2 of 5"), std::string::npos);
  const Image image = comparison_image(plan, "g", points, names);
  EXPECT_EQ(image.rgb.size(), std::size_t(3) * image.width * image.height);
}

}  // namespace
}  // namespace hybrid
