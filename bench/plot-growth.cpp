// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, the hybrid mapping authors

// Draws the time per step against the size of the graph, from the CSV files of bench-incremental
// and bench-bounded, or with --scale time and memory of whole tasks, from those of bench-scale.

#include <fmt/format.h>

#include <CLI/CLI.hpp>
#include <algorithm>
#include <cmath>
#include <filesystem>
#include <fstream>
#include <sstream>
#include <stdexcept>
#include <string>
#include <vector>

#include "libhybrid/io/parse_number.h"
#include "libhybrid/io/write_file.h"
#include "mrpt_plugins/drawing/plot.h"

namespace hybrid {
namespace {

constexpr std::size_t kColors = 6;  // before series_color repeats

double number(const std::string& text, const std::string& where) {
  double value = 0.0;
  if (!parse_number(text, value)) {
    throw std::runtime_error(fmt::format("{}: '{}' is not a number", where, text));
  }
  return value;
}

/// Calls visit(cells, where) for each row of a file that begins with `header`.
template <class Visit>
void for_each_row(const std::string& path, const std::string& header, const Visit& visit) {
  std::ifstream in(path);
  std::string line;
  if (!std::getline(in, line) || line != header) {
    throw std::runtime_error(fmt::format("{}: the first line must be '{}'", path, header));
  }
  const auto columns = 1 + std::count(header.begin(), header.end(), ',');
  for (int row = 2; std::getline(in, line); ++row) {
    const std::string where = fmt::format("{}:{}", path, row);
    std::vector<std::string> cells;
    std::istringstream words(line);
    for (std::string cell; std::getline(words, cell, ',');) cells.push_back(cell);
    if (std::ptrdiff_t(cells.size()) != columns) {
      throw std::runtime_error(fmt::format("{}: {} columns expected", where, columns));
    }
    visit(cells, where);
  }
}

/// Adds a point to the series of this name, a new one at the end if needed.
void add_point(std::vector<Series>& series, const std::string& name, double x, double y) {
  const auto found =
      std::find_if(series.begin(), series.end(), [&](const Series& s) { return s.label == name; });
  const std::size_t i = static_cast<std::size_t>(found - series.begin());
  if (found == series.end()) {
    series.push_back({name, {}, {}, series_color(i)});
    if (i >= kColors) series.back().line = LineStyle::kDashed;
  }
  series[i].x.push_back(x);
  series[i].y.push_back(y);
}

/// The graph of a series of a peer, "GRAPH iSAM2"; empty for others.
std::string graph_of_peer(const Series& series) {
  const std::string peer = " iSAM2";
  if (series.label.size() <= peer.size()) return {};
  const std::size_t end = series.label.size() - peer.size();
  return series.label.substr(end) == peer ? series.label.substr(0, end) : std::string();
}

/// Where there are peers, a graph and its peer have one colour, and the peer is dashed.
void color_by_graph(std::vector<Series>& series) {
  if (std::all_of(series.begin(), series.end(),
                  [](const Series& s) { return graph_of_peer(s).empty(); }))
    return;
  std::size_t graphs = 0;
  for (Series& s : series) {
    if (!graph_of_peer(s).empty()) continue;
    s.color = series_color(graphs++);
    s.line = LineStyle::kSolid;
  }
  for (Series& s : series) {
    const std::string graph = graph_of_peer(s);
    if (graph.empty()) continue;
    s.line = LineStyle::kDashed;
    for (const Series& of : series) {
      if (of.label == graph) s.color = of.color;
    }
  }
}

/// Files of bench-incremental and bench-isam2: the time per step.
void draw_steps(const std::vector<std::string>& files, const std::string& output) {
  PlotSpec plot;
  plot.title = "Time per step of the incremental smoother";
  plot.subtitle = "processor time, means over stretches of the run";
  plot.x = {"poses so far", Scale::kLog};
  plot.y = {"time per step (ms)", Scale::kLog};
  for (const std::string& file : files) {
    for_each_row(file, "graph,poses,cpu_us", [&](const auto& cells, const std::string& where) {
      add_point(plot.series, cells[0], number(cells[1], where), 1e-3 * number(cells[2], where));
    });
  }
  color_by_graph(plot.series);
  write_file(output + "/growth.png", png(render(plot)));
}

/// Least-squares slope in the logarithms, as a label.
std::string with_slope(const Series& series) {
  double n = 0, sx = 0, sy = 0, sxx = 0, sxy = 0;
  for (std::size_t i = 0; i < series.x.size(); ++i) {
    const double u = std::log(series.x[i]), v = std::log(series.y[i]);
    n += 1, sx += u, sy += v, sxx += u * u, sxy += u * v;
  }
  if (n < 2) return series.label;
  return fmt::format("{}: n^{:.2f}", series.label, (n * sxy - sx * sy) / (n * sxx - sx * sx));
}

/// Files of bench-scale: time and memory of whole tasks.
void draw_scale(const std::vector<std::string>& files, const std::string& output) {
  PlotSpec time, memory;
  time.title = "Processor time of whole tasks";
  memory.title = "Peak memory of whole tasks";
  time.subtitle = memory.subtitle = "slopes by least squares in the logarithms";
  time.x = memory.x = {"poses", Scale::kLog};
  time.y = {"processor time (s)", Scale::kLog};
  memory.y = {"peak memory (MiB)", Scale::kLog};
  for (const std::string& file : files) {
    for_each_row(
        file, "case,poses,cpu_s,peak_mib", [&](const auto& cells, const std::string& where) {
          add_point(time.series, cells[0], number(cells[1], where), number(cells[2], where));
          add_point(memory.series, cells[0], number(cells[1], where), number(cells[3], where));
        });
  }
  for (PlotSpec* plot : {&time, &memory}) {
    for (Series& series : plot->series) series.label = with_slope(series);
  }
  write_file(output + "/scale_time.png", png(render(time)));
  write_file(output + "/scale_memory.png", png(render(memory)));
}

}  // namespace
}  // namespace hybrid

int main(int argc, char** argv) try {
  CLI::App app("Growth of time and memory with the size of a graph");
  std::vector<std::string> files;
  std::string output = "growth";
  bool scale = false;
  app.add_option("CSV", files, "files of bench-incremental --csv")->required();
  app.add_flag("--scale", scale, "the files are of bench-scale --csv");
  app.add_option("-o,--output", output, "folder for growth.png, or scale_*.png")
      ->capture_default_str();
  CLI11_PARSE(app, argc, argv);

  std::filesystem::create_directories(output);
  scale ? hybrid::draw_scale(files, output) : hybrid::draw_steps(files, output);
  return 0;
} catch (const std::exception& e) {
  fmt::print(stderr, "plot-growth: {}\n", e.what());
  return 1;
}
