// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, the hybrid mapping authors

#include "mrpt_plugins/output/figures.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <stdexcept>

#include "mrpt_plugins/drawing/plot.h"
#include "mrpt_plugins/output/summary.h"

namespace hybrid {
namespace {

/// Position errors [m]. Errors below 0.1 mm, such as that of the pose that defines the map, are
/// left out, since they would stretch a logarithmic axis.
std::vector<double> position_errors(const std::vector<PosePair>& pairs) {
  constexpr double kLeast = 1e-4;
  std::vector<double> out;
  for (const PosePair& p : pairs) {
    const double error = (p.truth - p.estimate).norm();
    out.push_back(error < kLeast ? std::numeric_limits<double>::quiet_NaN() : error);
  }
  return out;
}

Series level(const std::string& label, double x_low, double x_high, double y, Color color) {
  Series s;
  s.label = label;
  s.x = {x_low, x_high};
  s.y = {y, y};
  s.color = color;
  s.line = LineStyle::kDashed;
  return s;
}

/// Whether at least half of the times are later than the one before. A few repeated times are
/// harmless; a clock that stands still gives no time axis.
bool clock_runs(const std::vector<double>& times) {
  std::size_t later = 0;
  for (std::size_t i = 1; i < times.size(); ++i) later += times[i] > times[i - 1];
  return times.empty() || 2 * later >= times.size() - 1;
}

/// Bounds of the Wilson score interval of a frequency, 95 %.
std::pair<double, double> wilson(double frequency, std::size_t count) {
  constexpr double kZ = 1.959964;
  const auto n = static_cast<double>(count);
  const double center = (frequency + kZ * kZ / (2 * n)) / (1 + kZ * kZ / n);
  const double half =
      kZ / (1 + kZ * kZ / n) * std::sqrt(frequency * (1 - frequency) / n + kZ * kZ / (4 * n * n));
  return {center - half, center + half};
}

}  // namespace

Image steps_image(const std::vector<StepRecord>& steps, const std::string& title) {
  PlotSpec plot;
  const StepStatistics s = step_statistics(steps);
  plot.title = title;
  plot.subtitle = fmt::format(
      "Time the solver took after each keyframe; {} keyframes, {:.3g} s in all, longest {:.3g} ms",
      steps.size(), s.total_s, s.max_ms);
  plot.x.label = "keyframe";
  plot.y.label = "solver time (ms)";
  plot.y.scale = Scale::kLog;
  plot.width = 1400;
  plot.height = 800;
  Series time;
  time.label = "one keyframe";
  time.line = LineStyle::kNone;
  time.marker = Marker::kCircle;
  time.marker_radius = steps.size() > 2000 ? 2 : 3.5;
  for (const StepRecord& step : steps) {
    time.x.push_back(static_cast<double>(time.x.size()));
    time.y.push_back(1e3 * step.seconds);
  }
  plot.series.push_back(time);
  if (!steps.empty()) {
    const auto [low, high] = std::minmax_element(time.x.begin(), time.x.end());
    plot.series.push_back(
        level(fmt::format("median {:.3g} ms", s.p50_ms), *low, *high, s.p50_ms, palette::kBlack));
    plot.series.push_back(level(fmt::format("95 % below {:.3g} ms", s.p95_ms), *low, *high,
                                s.p95_ms, palette::kDeadReckoning));
  }
  return render(plot);
}

Image error_image(const std::vector<double>& times, const std::vector<PosePair>& estimate,
                  const std::vector<PosePair>& dead_reckoning, const std::string& title) {
  PlotSpec plot;
  plot.title = title;
  plot.subtitle = "Distance between estimated and true position; lower is better";
  const bool timed = clock_runs(times);
  plot.x.label = timed ? "time since the start (s)" : "keyframe";
  plot.y.label = "position error (m)";
  plot.y.scale = Scale::kLog;
  plot.width = 1400;
  plot.height = 800;
  const auto add = [&](std::vector<PosePair> pairs, const std::string& name, Color color) {
    if (pairs.empty()) return;
    if (pairs.size() != times.size()) {
      throw std::invalid_argument(
          fmt::format("{} errors of {} but {} times", pairs.size(), name, times.size()));
    }
    Series s;
    s.color = color;
    for (std::size_t i = 0; i < times.size(); ++i) {
      s.x.push_back(timed ? times[i] - times.front() : static_cast<double>(i));
    }
    s.y = position_errors(pairs);
    s.label = name;
    plot.series.push_back(s);
    const mrpt::poses::CPose3D T_truth_estimate = alignment(pairs);
    for (PosePair& p : pairs) p.estimate = T_truth_estimate + p.estimate;
    s.y = position_errors(pairs);
    s.label = name + ", after rigid alignment";
    s.line = LineStyle::kDotted;
    plot.series.push_back(s);
  };
  add(dead_reckoning, "dead reckoning", palette::kDeadReckoning);
  add(estimate, "estimate", palette::kEstimate);
  return render(plot);
}

Image reliability_image(const Calibration& calibration, const std::string& title,
                        const ReliabilityNames& names) {
  PlotSpec plot;
  plot.title = title;
  plot.subtitle =
      fmt::format("{} {}, Brier score {:.2g}, log loss {:.2g}, calibration error {:.2g}",
                  calibration.predictions, names.things, calibration.brier, calibration.log_loss,
                  calibration.expected_error);
  plot.x = {names.stated, Scale::kLinear, {{0.0, 1.0}}};
  plot.y = {names.observed, Scale::kLinear, {{-0.02, 1.02}}};
  plot.width = 1000;
  plot.height = 1060;
  Series diagonal;
  diagonal.label = "calibrated";
  diagonal.x = diagonal.y = {0, 1};
  diagonal.color = palette::kTruth;
  diagonal.line = LineStyle::kDashed;
  Series observed;
  observed.label = "observed, 95 % interval, number of predictions";
  observed.marker = Marker::kCircle;
  observed.marker_radius = 7;
  for (const ReliabilityBin& bin : calibration.bins) {
    if (bin.count == 0) continue;
    observed.x.push_back(bin.mean_predicted);
    observed.y.push_back(bin.observed);
    const auto [low, high] = wilson(bin.observed, bin.count);
    observed.lower.push_back(low);
    observed.upper.push_back(high);
    observed.notes.push_back(std::to_string(bin.count));
  }
  plot.series = {diagonal, observed};
  return render(plot);
}

}  // namespace hybrid
