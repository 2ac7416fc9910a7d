// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, the hybrid mapping authors

#include "mrpt_plugins/experiment/statistics.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>

#include "mrpt_plugins/experiment/pose_graph_trial.h"

namespace hybrid {
namespace {

std::string number(double value) {
  return std::isfinite(value) ? fmt::format("{}", value) : "";
}

std::string shown(double value, bool few_digits) {
  if (!std::isfinite(value)) return "-";
  return few_digits ? fmt::format("{:.3g}", value) : fmt::format("{:.4f}", value);
}

bool same_point(const PointSummary& point, const Trial& trial) {
  return point.graph == trial.graph && point.variant == trial.variant &&
         point.method == trial.method && point.outlier_rate == trial.outlier_rate;
}

/// The value for a trial without an estimate: worse than any number.
double worst(const std::string& metric) {
  const bool more_is_better = metric == "precision" || metric == "recall";
  return (more_is_better ? -1.0 : 1.0) * std::numeric_limits<double>::infinity();
}

/// Columns of a text table, as wide as their widest cells.
std::string aligned(const std::vector<std::vector<std::string>>& rows) {
  std::vector<std::size_t> widths(rows.front().size(), 0);
  for (const auto& row : rows) {
    for (std::size_t c = 0; c < row.size(); ++c) widths[c] = std::max(widths[c], row[c].size());
  }
  std::string text;
  for (const auto& row : rows) {
    std::string line;
    for (std::size_t c = 0; c < row.size(); ++c) {
      line += c < 3 ? fmt::format("{:<{}}  ", row[c], widths[c])
                    : fmt::format("{:>{}}  ", row[c], widths[c]);
    }
    text += line.substr(0, line.find_last_not_of(' ') + 1) + "\n";
  }
  return text;
}

}  // namespace

Quartiles quartiles(std::vector<double> values) {
  std::sort(values.begin(), values.end());
  const auto at = [&](double share) {
    if (values.empty()) return std::numeric_limits<double>::quiet_NaN();
    const double place = share * static_cast<double>(values.size() - 1);
    const auto below = static_cast<std::size_t>(place);
    const std::size_t above = std::min(below + 1, values.size() - 1);
    const double share_above = place - static_cast<double>(below);
    if (share_above == 0.0 || values[above] == values[below]) return values[below];
    return values[below] + share_above * (values[above] - values[below]);
  };
  return {at(0.25), at(0.5), at(0.75)};
}

std::vector<PointSummary> summarize(const ExperimentPlan& plan, const Ledger& ledger) {
  std::vector<PointSummary> points;
  std::vector<std::vector<std::vector<double>>> values;  // by point, metric
  for (const Trial& trial : trials_of(plan)) {
    if (!ledger.contains(trial) || !ledger.at(trial).finished()) continue;
    auto it = std::find_if(points.begin(), points.end(),
                           [&](const PointSummary& p) { return same_point(p, trial); });
    if (it == points.end()) {
      PointSummary point;
      point.graph = trial.graph;
      point.variant = trial.variant;
      point.method = trial.method;
      point.outlier_rate = trial.outlier_rate;
      points.push_back(point);
      values.emplace_back(ledger.metrics().size());
      it = points.end() - 1;
    }
    const TrialResult& result = ledger.at(trial);
    ++it->trials;
    const bool measured = result.status == "ok" || result.status == "partial";
    if (measured) ++it->measured;
    const auto ate = result.metrics.find("ate_mean_m");
    if (ate != result.metrics.end() && ate->second <= plan.success_ate) it->success += 1.0;
    for (std::size_t m = 0; m < ledger.metrics().size(); ++m) {
      const std::string& name = ledger.metrics()[m];
      const auto value = result.metrics.find(name);
      if (value == result.metrics.end() && measured) continue;  // the metric does not apply
      values[static_cast<std::size_t>(it - points.begin())][m].push_back(
          value != result.metrics.end() ? value->second : worst(name));
    }
  }
  for (std::size_t p = 0; p < points.size(); ++p) {
    points[p].success /= static_cast<double>(points[p].trials);
    for (const auto& metric : values[p]) points[p].metrics.push_back(quartiles(metric));
  }
  return points;
}

std::string summary_csv(const std::vector<PointSummary>& points,
                        const std::vector<std::string>& metrics) {
  std::string text = "graph,variant,method,outlier_rate,trials,measured,success_rate";
  for (const std::string& name : metrics) {
    text += fmt::format(",{0}_median,{0}_q1,{0}_q3", name);
  }
  text += "\n";
  for (const PointSummary& point : points) {
    text += fmt::format("{},{},{},{},{},{},{}", point.graph, point.variant, point.method,
                        point.outlier_rate, point.trials, point.measured, point.success);
    for (const Quartiles& q : point.metrics) {
      text += fmt::format(",{},{},{}", number(q.median), number(q.q1), number(q.q3));
    }
    text += "\n";
  }
  return text;
}

std::string summary_table(const ExperimentPlan& plan, const std::vector<PointSummary>& points,
                          const std::vector<std::string>& metrics) {
  std::vector<std::string> columns = {"ate_mean_m", "rotation_mean_deg", "cpu_s", "precision",
                                      "recall"};
  if (plan.replay) columns = metrics;
  std::vector<std::vector<std::string>> rows(1);
  rows[0] = {"graph", "variant", "method", "outliers", "trials"};
  if (!plan.replay) rows[0].emplace_back("success");
  for (const std::string& name : columns) {
    rows[0].push_back(name);
    if (name == "ate_mean_m") rows[0].emplace_back("quartiles");
  }
  for (const PointSummary& point : points) {
    std::vector<std::string> row = {
        point.graph, point.variant, point.method, fmt::format("{:g}", point.outlier_rate),
        point.measured == point.trials ? std::to_string(point.trials)
                                       : fmt::format("{} of {}", point.measured, point.trials)};
    if (!plan.replay) row.push_back(fmt::format("{:.0f} %", 100.0 * point.success));
    for (const std::string& name : columns) {
      const auto m = static_cast<std::size_t>(std::find(metrics.begin(), metrics.end(), name) -
                                              metrics.begin());
      const Quartiles& q = point.metrics.at(m);
      const bool few = name != "ate_mean_m";
      row.push_back(shown(q.median, few));
      if (!few) row.push_back(shown(q.q1, few) + " " + shown(q.q3, few));
    }
    rows.push_back(row);
  }
  return aligned(rows);
}

Calibration calibration_of(const ExperimentPlan& plan, const Ledger& ledger,
                           const std::string& method) {
  ReliabilitySum sum;
  for (const Trial& trial : trials_of(plan)) {
    if (trial.method != method || !ledger.contains(trial)) continue;
    const TrialResult& result = ledger.at(trial);
    if (result.reliability.empty()) continue;
    sum.add(result.reliability, result.metrics.at("brier"), result.metrics.at("log_loss"));
  }
  return sum.calibration();
}

}  // namespace hybrid
