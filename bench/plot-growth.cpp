// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, the hybrid mapping authors

// Draws the time per step against the size of the graph, from the CSV files of bench-incremental.

#include <fmt/format.h>

#include <CLI/CLI.hpp>
#include <filesystem>
#include <fstream>
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

/// Adds the rows "graph,poses,cpu_us" of a file to the series of their graphs.
void read_rows(const std::string& path, std::vector<Series>& series) {
  std::ifstream in(path);
  std::string line;
  if (!std::getline(in, line) || line != "graph,poses,cpu_us") {
    throw std::runtime_error(path + ": the first line must be 'graph,poses,cpu_us'");
  }
  for (int row = 2; std::getline(in, line); ++row) {
    const std::string where = fmt::format("{}:{}", path, row);
    const auto first = line.find(','), second = line.find(',', first + 1);
    if (second == std::string::npos) throw std::runtime_error(where + ": three columns expected");
    const std::string graph = line.substr(0, first);
    if (series.empty() || series.back().label != graph) {
      const std::size_t i = series.size();
      series.push_back({graph, {}, {}, series_color(i)});
      if (i >= kColors) series.back().line = LineStyle::kDashed;
    }
    series.back().x.push_back(number(line.substr(first + 1, second - first - 1), where));
    series.back().y.push_back(number(line.substr(second + 1), where) * 1e-3);
  }
}

}  // namespace
}  // namespace hybrid

int main(int argc, char** argv) try {
  CLI::App app("Time per step against the size of the graph");
  std::vector<std::string> files;
  std::string output = "growth";
  app.add_option("CSV", files, "files of bench-incremental --csv")->required();
  app.add_option("-o,--output", output, "folder for growth.png")->capture_default_str();
  CLI11_PARSE(app, argc, argv);

  hybrid::PlotSpec plot;
  plot.title = "Time per step of the incremental smoother";
  plot.subtitle = "processor time, means over stretches of the run";
  plot.x = {"poses so far", hybrid::Scale::kLog};
  plot.y = {"time per step (ms)", hybrid::Scale::kLog};
  for (const std::string& file : files) hybrid::read_rows(file, plot.series);
  std::filesystem::create_directories(output);
  hybrid::write_file(output + "/growth.png", hybrid::png(hybrid::render(plot)));
  return 0;
} catch (const std::exception& e) {
  fmt::print(stderr, "plot-growth: {}\n", e.what());
  return 1;
}
