// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, the hybrid mapping authors

#include "mrpt_plugins/experiment/plots.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <stdexcept>

#include "libhybrid/io/parse_number.h"
#include "mrpt_plugins/drawing/canvas.h"
#include "mrpt_plugins/drawing/heading.h"
#include "mrpt_plugins/drawing/plot.h"

namespace hybrid {
namespace {

struct Panel {
  const char* metric;
  const char* label;
  double floor;  // smaller values are drawn at this one
};

constexpr Panel kPanels[] = {{"ate_mean_m", "mean position error (m)", 1e-4},
                             {"rotation_mean_deg", "mean rotation error (deg)", 1e-4},
                             {"cpu_s", "processor time of the solver (s)", 1e-3}};

std::size_t place(const std::vector<std::string>& names, const std::string& name) {
  const auto it = std::find(names.begin(), names.end(), name);
  if (it == names.end()) throw std::invalid_argument("there is no metric '" + name + "'");
  return static_cast<std::size_t>(it - names.begin());
}

/// Colour, marker and line style of a method: the same in all panels.
Series series_of(std::size_t method, const std::string& name) {
  Series series;
  series.label = name;
  series.color = series_color(method);
  series.marker = class_marker(method);
  series.marker_radius = 5;
  series.line = method < 6 ? LineStyle::kSolid : LineStyle::kDashed;
  series.band = true;
  return series;
}

/// Whether all variants are numbers; these then are their coordinates on the axis.
bool numeric(const std::vector<std::string>& variants, std::vector<double>& values) {
  for (const std::string& text : variants) {
    double value = 0;
    if (!parse_number(text, value)) return false;
    values.push_back(value);
  }
  return true;
}

/// A heading with a title and a line that describes the picture.
Image heading(const std::string& title, const std::string& about, int width) {
  Canvas canvas(width, 84);
  draw_heading(canvas, {60, 34}, width - 2 * 60, title, about);
  return canvas.image();
}

/// Joins two pictures of the same width, one above the other.
Image stacked(Image above, const Image& below) {
  above.height += below.height;
  above.rgb.insert(above.rgb.end(), below.rgb.begin(), below.rgb.end());
  above.drawing = nullptr;
  return above;
}

/// The value to draw: at least `floor`; NaN, which plots leave out, if not finite.
double drawn(double value, double floor = std::numeric_limits<double>::lowest()) {
  return std::isfinite(value) ? std::max(floor, value) : std::numeric_limits<double>::quiet_NaN();
}

std::string replay_name(const std::string& replay, const std::string& log) {
  return log.empty() ? replay : replay + "/" + log;
}

}  // namespace

Image side_by_side(const std::vector<Image>& images) {
  Image all;
  for (const Image& image : images) {
    if (all.height != 0 && image.height != all.height) {
      throw std::invalid_argument("pictures side by side must have the same height");
    }
    all.height = image.height;
    all.width += image.width;
  }
  all.rgb.reserve(std::size_t(3) * all.width * all.height);
  for (int y = 0; y < all.height; ++y) {
    for (const Image& image : images) {
      const auto row = image.rgb.begin() + std::ptrdiff_t(3) * image.width * y;
      all.rgb.insert(all.rgb.end(), row, row + std::ptrdiff_t(3) * image.width);
    }
  }
  return all;
}

Image comparison_image(const ExperimentPlan& plan, const std::string& graph,
                       const std::vector<PointSummary>& points,
                       const std::vector<std::string>& metrics) {
  const auto found = std::find_if(plan.graphs.begin(), plan.graphs.end(),
                                  [&](const GraphPlan& g) { return g.name == graph; });
  if (found == plan.graphs.end()) throw std::invalid_argument("there is no graph '" + graph + "'");
  const bool by_variant = found->variants.size() > 1;
  std::vector<double> variants;
  const bool has_numbers = by_variant && numeric(found->variants, variants);
  const auto x_of = [&](const PointSummary& point) {
    if (!by_variant) return 100.0 * point.outlier_rate;
    const std::size_t v = place(found->variants, point.variant);
    return has_numbers ? variants[v] : static_cast<double>(v + 1);
  };
  std::vector<Image> panels;
  for (const Panel& panel : kPanels) {
    PlotSpec plot;
    plot.x.label = by_variant ? found->variant_label : "false among all closures (%)";
    plot.y = {panel.label, Scale::kLog, std::nullopt};
    plot.width = 760;
    plot.height = 700;
    const std::size_t m = place(metrics, panel.metric);
    for (std::size_t i = 0; i < plan.methods.size(); ++i) {
      Series series = series_of(i, plan.methods[i]);
      for (const PointSummary& point : points) {
        if (point.method != plan.methods[i] || point.graph != graph) continue;
        const Quartiles& q = point.metrics.at(m);
        series.x.push_back(x_of(point));
        series.y.push_back(drawn(q.median, panel.floor));
        series.lower.push_back(drawn(q.q1, panel.floor));
        series.upper.push_back(drawn(q.q3, panel.floor));
      }
      plot.series.push_back(series);
    }
    panels.push_back(render(plot));
  }
  const Image row = side_by_side(panels);
  const bool has_seeds =
      std::any_of(points.begin(), points.end(), [](const auto& p) { return p.trials > 1; });
  const std::string about = fmt::format(
      "{}; errors below 0.0001 are drawn there. Time of one thread.",
      has_seeds ? "Median over seeds, band between the quartiles" : "One trial per point");
  return stacked(heading(fmt::format("{}: {}", plan.title, graph), about, row.width), row);
}

Image replay_image(const ExperimentPlan& plan, const std::string& metric,
                   const std::vector<PointSummary>& points,
                   const std::vector<std::string>& metrics) {
  PlotSpec plot;
  plot.title = fmt::format("{}: {}", plan.title, metric);
  plot.subtitle = "Median with quartiles over seeds; replays";
  plot.y.label = metric;
  plot.x.label = "replay";
  plot.width = 1100;
  plot.height = 700;
  std::vector<std::string> names;
  for (const ReplayPlan& replay : plan.replays) {
    for (const ReplayPlan::Log& log : replay.logs) {
      names.push_back(replay_name(replay.name, log.name));
      plot.subtitle +=
          fmt::format("{} {} = {}", names.size() == 1 ? "" : ",", names.size(), names.back());
    }
  }
  plot.x.range = {{0.5, static_cast<double>(names.size()) + 0.5}};
  const std::size_t m = place(metrics, metric);
  for (std::size_t i = 0; i < plan.methods.size(); ++i) {
    Series series = series_of(i, plan.methods[i]);
    series.band = false;
    series.line = LineStyle::kNone;
    series.marker_radius = 8;
    const double shift =
        plan.methods.size() == 1 ? 0.0 : 0.5 * (double(i) / double(plan.methods.size() - 1) - 0.5);
    for (const PointSummary& point : points) {
      if (point.method != plan.methods[i]) continue;
      const Quartiles& q = point.metrics.at(m);
      series.x.push_back(
          static_cast<double>(place(names, replay_name(point.graph, point.variant)) + 1) + shift);
      series.y.push_back(drawn(q.median));
      series.lower.push_back(drawn(q.q1));
      series.upper.push_back(drawn(q.q3));
    }
    plot.series.push_back(series);
  }
  return render(plot);
}

}  // namespace hybrid
