// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, the hybrid mapping authors

// Reading and writing of pose graphs, in MB per second of processor time.
#include <CLI/CLI.hpp>
#include <algorithm>
#include <cstdio>
#include <cstdlib>
#include <filesystem>
#include <iostream>
#include <string>
#include <vector>

#include "bench/scale_worlds.h"
#include "bench/stopwatch.h"
#include "libhybrid/io/read_graph.h"
#include "libhybrid/io/write_graph.h"

namespace {

using namespace hybrid;
using namespace hybrid::bench;

constexpr int kRepeats = 5;

/// Processor time [s] of one of the calls, the median.
template <class Call>
double seconds(const Call& call) {
  std::vector<double> times;
  for (int k = 0; k < kRepeats; ++k) {
    const Stopwatch watch;
    call();
    times.push_back(watch.elapsed().cpu);
  }
  return distribution(times).p50;
}

void measure(const std::string& name, const std::string& file) {
  const double megabytes = 1e-6 * static_cast<double>(std::filesystem::file_size(file));
  const PoseGraph graph = read_graph(file);
  const std::string copy = file + ".copy.g2o";
  const double read = seconds([&] { read_graph(file); });
  std::size_t bytes = 0;
  const double text = seconds([&] { bytes = to_g2o(graph).size(); });
  const double write = seconds([&] { write_g2o(copy, graph); });
  std::filesystem::remove(copy);
  const double written = 1e-6 * static_cast<double>(bytes);
  std::printf(
      "%-12s %7.1f MB, %zu edges: read %.3f s, %.0f MB/s; write %.3f s, %.0f MB/s, of which "
      "text %.3f s\n",
      name.c_str(), megabytes, graph.edge_count(), read, megabytes / read, write, written / write,
      text);
}

void run(int poses, const std::vector<std::string>& files) {
  for (const std::string& file : files) measure(std::filesystem::path(file).stem(), file);
  if (!files.empty()) return;
  const std::string file =
      (std::filesystem::temp_directory_path() / "hybrid_bench_graph_io.g2o").string();
  for (const char* name : {"manhattan", "city", "sphere"}) {
    World world = scale_world(name, poses, 1);
    world.graph.values = world.truth;
    write_g2o(file, world.graph);
    measure(name, file);
  }
  std::filesystem::remove(file);
}

}  // namespace

int main(int argc, char** argv) try {
  CLI::App app(
      "Reading and writing of pose graphs, in MB per second of processor time; each figure is the "
      "median of five");
  int poses = 100000;
  std::vector<std::string> files;
  app.add_option("FILE", files, "Graphs; without any, generated worlds are written and read");
  app.add_option("--poses", poses, "Poses of a generated world")
      ->check(CLI::Range(100, 100000000))
      ->capture_default_str();
  CLI11_PARSE(app, argc, argv);
  run(poses, files);
  return EXIT_SUCCESS;
} catch (const std::exception& e) {
  std::fprintf(stderr, "bench-graph-io: %s\n", e.what());
  return EXIT_FAILURE;
}
