// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, the hybrid mapping authors

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <nlohmann/json.hpp>
#include <numeric>
#include <utility>

#include "apps/exit_code.h"
#include "apps/hybrid-switching/locate.h"
#include "apps/hybrid-switching/reports.h"
#include "apps/program.h"
#include "libhybrid/core/error.h"
#include "libhybrid/core/sort_unique.h"
#include "mrpt_plugins/bridge/output_directory.h"
#include "mrpt_plugins/output/mode_image.h"

namespace hybrid {
namespace {

using Json = nlohmann::ordered_json;

const std::vector<std::string> kModeNames = {"in line of sight", "not in line of sight"};

Json error_json(const std::vector<double>& errors) {
  const double n = static_cast<double>(errors.size());
  const double sum = std::accumulate(errors.begin(), errors.end(), 0.0);
  const double squares = std::inner_product(errors.begin(), errors.end(), errors.begin(), 0.0);
  return {{"points", errors.size()},
          {"mean_m", sum / n},
          {"rmse_m", std::sqrt(squares / n)},
          {"max_m", *std::max_element(errors.begin(), errors.end())}};
}

std::string trajectory_csv(const Located& located) {
  std::string text = "time,x,y,angle\n";
  for (std::size_t i = 0; i < located.path.size(); ++i) {
    const SE2& T = located.path[i];
    text += fmt::format("{:.6f},{:.6f},{:.6f},{:.6f}\n", located.times[i], T.x(), T.y(), T.angle());
  }
  return text;
}

/// Range minus distance from the estimate [m].
double residual(const Located& located, const AnchorRange& r) {
  const auto it = std::lower_bound(located.times.begin(), located.times.end(), r.time);
  return r.range - (located.path[it - located.times.begin()].translation() - r.anchor).norm();
}

std::string ranges_csv(const RangeLog& log, const Located& located) {
  std::string text = "line,time,anchor,range,residual,p_not_in_line_of_sight\n";
  for (std::size_t i = 0; i < log.ranges.size(); ++i) {
    const AnchorRange& r = log.ranges[i];
    text += fmt::format("{},{:.6f},{},{:.6f},{:.6f},{:.6g}\n", r.line, r.time, r.anchor_id, r.range,
                        residual(located, r), located.non_line_of_sight[i]);
  }
  return text;
}

Image timeline(const Options& options, const RangeLog& log, const Located& located) {
  ModeTimeline t;
  t.title = "Ranges of " + std::filesystem::path(options.input).filename().string();
  t.subtitle = fmt::format(
      "Modes of {} ranges; learnt: {:+.2f} m +- {:.2f} in line of sight, "
      "{:+.2f} m +- {:.2f} not",
      log.ranges.size(), located.modes.bias[0], located.modes.sigma[0], located.modes.bias[1],
      located.modes.sigma[1]);
  t.x_label = "range, in order of time";
  t.y_label = "range minus distance (m)";
  t.mode_names = kModeNames;
  t.points = true;
  std::vector<int> anchors, all;
  for (const AnchorRange& r : log.ranges) anchors.push_back(r.anchor_id);
  sort_unique(anchors);
  for (std::size_t i = 0; i < log.ranges.size(); ++i) {
    t.x.push_back(static_cast<double>(i));
    t.curve.push_back(residual(located, log.ranges[i]));
    all.push_back(located.non_line_of_sight[i] > 0.5 ? 1 : 0);
  }
  for (int anchor : anchors) {
    ModeStrip strip{fmt::format("anchor {}", anchor), std::vector<int>(all.size(), -1)};
    int last = -1;  // a mode lasts until the next range of its anchor
    for (std::size_t i = 0; i < all.size(); ++i) {
      if (log.ranges[i].anchor_id == anchor) last = all[i];
      strip.modes[i] = last;
    }
    t.strips.push_back(std::move(strip));
  }
  t.strips.push_back({"all", all});
  return mode_timeline_image(t);
}

Image path(const RangeLog& log, const Located& located, const std::vector<TruePoint>& truth,
           const std::string& subtitle) {
  ModePath p;
  p.title = "Path of the robot, in the colour of the range measured there";
  p.subtitle = subtitle;
  p.mode_names = kModeNames;
  for (const TruePoint& point : truth) p.truth.push_back(point.position);
  for (std::size_t i = 0; i < log.ranges.size(); ++i) {
    const auto it =
        std::lower_bound(located.times.begin(), located.times.end(), log.ranges[i].time);
    p.points.push_back(located.path[it - located.times.begin()].translation());
    p.modes.push_back(located.non_line_of_sight[i] > 0.5 ? 1 : 0);
  }
  p.markers = true;
  return mode_path_image(p);
}

Json to_json(const Located& located) {
  Json out = {{"objective", located.objective}, {"solver_s", located.seconds}};
  if (located.non_line_of_sight.empty()) return out;
  const RangeModes& m = located.modes;
  out["rounds"] = located.rounds;
  out["bias_m"] = m.bias;
  out["sigma_m"] = m.sigma;
  out["stay"] = {m.chain.transition(0, 0), m.chain.transition(1, 1)};
  return out;
}

}  // namespace

int report_ranges(const Options& options) {
  const RangeLog log = read_range_log(options.input);
  std::vector<TruePoint> truth;
  if (!options.truth.empty()) truth = read_true_points(options.truth);
  const auto all = about({options.input}, [&] {
    return std::vector<Located>{locate_with_modes(log), locate(log, "cauchy", Loss::cauchy()),
                                locate(log, "narrow cauchy", Loss::cauchy(1.0)),
                                locate(log, "gaussian", Loss::none())};
  });
  Provenance provenance = options.provenance;
  for (const std::string& path : {options.input, options.truth}) provenance.add_input(path);
  warn_of_inputs(provenance);
  Json summary = summary_start("ok", "", provenance);
  summary["ranges"] = log.ranges.size();
  summary["poses"] = all[0].path.size();
  std::string errors_text;
  for (const Located& located : all) {
    Json method = to_json(located);
    if (!truth.empty()) {
      const std::vector<double> errors = position_errors(located, truth);
      if (errors.empty()) throw Error(options.truth + ": no point at the time of a pose");
      method["truth"] = error_json(errors);
      errors_text += fmt::format("{}{} {:.3f} m", errors_text.empty() ? "mean error: " : ", ",
                                 located.method, method["truth"]["mean_m"].get<double>());
    }
    summary["methods"][located.method] = method;
  }
  OutputDirectory out(options.output);
  out.write("trajectory.csv", trajectory_csv(all[0]));
  out.write("ranges.csv", ranges_csv(log, all[0]));
  if (options.pictures) {
    out.write("modes.png", png(timeline(options, log, all[0])));
    out.write("path.png", png(path(log, all[0], truth, errors_text)));
  }
  const std::vector<std::string> told = out.publish(std::move(summary));
  const int code = settle(kExitOk);
  for (const std::string& text : told) complain("hybrid-switching: {}\n", text);
  say("{} ranges, {} poses{}{} -> {}\n", log.ranges.size(), all[0].path.size(),
      errors_text.empty() ? "" : ", ", errors_text, options.output);
  return code;
}

}  // namespace hybrid
