// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, the hybrid mapping authors

// Reading and writing of pose graphs, in MB per second of processor time:
//   bench-graph-io [--poses N] [FILE...]
// Without files, of the generated worlds of bench-scale. Each figure is the median of five.
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

void run(int argc, char** argv) {
  int poses = 100000;
  std::vector<std::string> files;
  for (int i = 1; i < argc; ++i) {
    const std::string argument = argv[i];
    if (argument == "--poses" && i + 1 < argc) {
      poses = std::max(100, std::atoi(argv[++i]));
    } else {
      files.push_back(argument);
    }
  }
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

int main(int argc, char** argv) {
  try {
    run(argc, argv);
  } catch (const std::exception& error) {
    std::cerr << "bench-graph-io: " << error.what() << "\n";
    return 1;
  }
  return 0;
}
