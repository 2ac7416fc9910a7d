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

/// By linear interpolation between the sorted values, which may be infinite; NaN without values.
Quartiles quartiles(std::vector<double> values);

/// All trials of one point of a plot.
struct PointSummary {
  std::string graph, variant, method;
  double outlier_rate = 0;
  std::size_t trials = 0;    ///< that were run to an end
  std::size_t measured = 0;  ///< of them, those that ended with an estimate
  double success = 0;        ///< share of the trials with a small enough error
  /// In the order of the ledger's, over all trials: one that ended without an estimate counts as
  /// worse than any that ended with one, so that a median of which half have none is infinite.
  std::vector<Quartiles> metrics;
};

/// One summary for each graph, variant, method and rate that has trials, in the order of the
/// trials. The time of a trial that was ended at its limit counts as that limit.
std::vector<PointSummary> summarize(const ExperimentPlan& plan, const Ledger& ledger);

/// summary.csv: the points with median and quartiles of every metric.
std::string summary_csv(const std::vector<PointSummary>& points,
                        const std::vector<std::string>& metrics);

/// The same for people, the most telling columns: of pose graphs mean error, rotation error, time,
/// success; of replays all metrics.
std::string summary_table(const ExperimentPlan& plan, const std::vector<PointSummary>& points,
                          const std::vector<std::string>& metrics);

/// Calibration of the inlier probabilities of one method over all trials.
Calibration calibration_of(const ExperimentPlan& plan, const Ledger& ledger,
                           const std::string& method);

}  // namespace hybrid
