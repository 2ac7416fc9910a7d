// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, the hybrid mapping authors

#pragma once

#include <string>
#include <vector>

#include "mrpt_plugins/evaluation/reliability.h"
#include "mrpt_plugins/experiment/ledger.h"
#include "mrpt_plugins/experiment/plan.h"

namespace HYBRID_API hybrid {

/// Quartiles of some numbers.
struct Quartiles {
  double q1 = 0, median = 0, q3 = 0;
};

/// Computes quartiles by linear interpolation between the sorted values, which may be infinite; NaN
/// without values.
Quartiles quartiles(std::vector<double> values);

/// All trials of one point of a plot.
struct PointSummary {
  std::string graph, variant, method;
  double outlier_rate = 0;
  std::size_t trials = 0;    ///< finished trials
  std::size_t measured = 0;  ///< of them, those with an estimate
  double success = 0;        ///< share of finished trials with an error up to success_ate
  /// Quartiles over finished trials, in the order of the ledger's metrics. A trial without an
  /// estimate counts as worse than any with one: if half of the trials have none, the median is
  /// infinite.
  std::vector<Quartiles> metrics;
};

/// One summary for each graph, variant, method and rate that has trials, in the order of the
/// trials. A trial that reached the time limit counts with that limit as its time.
std::vector<PointSummary> summarize(const ExperimentPlan& plan, const Ledger& ledger);

/// summary.csv: the points with median and quartiles of every metric.
std::string summary_csv(const std::vector<PointSummary>& points,
                        const std::vector<std::string>& metrics);

/// A text table of the main columns: for pose graphs position error, rotation error, time and
/// success; for replays all metrics.
std::string summary_table(const ExperimentPlan& plan, const std::vector<PointSummary>& points,
                          const std::vector<std::string>& metrics);

/// Calibration of the inlier probabilities of one method over all trials.
Calibration calibration_of(const ExperimentPlan& plan, const Ledger& ledger,
                           const std::string& method);

}  // namespace hybrid
