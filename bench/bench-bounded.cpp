// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, the hybrid mapping authors

// A robot that circles among 20 landmarks for as long as asked: what a keyframe costs, and how good
// and how sure the estimate is, by full smoothing and by a window that the place bounds.
//
//   bench-bounded [--steps N] [--full N] [--runs N] [--seed N] [--complete N] [--sightings N]
//                 [--csv FILE]
//
// Full smoothing ends after --full steps. Time is that of the processor per keyframe, memory that
// of the smoother. NEES is the normalised estimation error squared of the newest pose for each
// degree of freedom, 1 where the covariance is right; it and the rms error are means since the line
// before, over all runs.

#include <CLI/CLI.hpp>
#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <exception>
#include <map>
#include <string>
#include <vector>

#include "bench/stopwatch.h"
#include "tests/support/consistency.h"

namespace hybrid {
namespace {

constexpr int kStretch = 100;  // steps of which the time is a mean

struct Options {
  int steps = 50000, full = 5000, runs = 1;
  std::uint64_t seed = 1;
  WindowOptions window;
  std::string csv;
};

/// What is printed at some steps, sums over runs.
struct Line {
  double nees = 0.0, squares = 0.0, heading_squares = 0.0, count = 0.0;
  double ms = 0.0, bytes = 0.0, states = 0.0, divergence = 0.0;
};

bool is_printed(int step) {
  int unit = 1;
  while (step >= 10 * unit) unit *= 10;
  return step >= 500 && (step == unit || step == 2 * unit || step == 3 * unit || step == 5 * unit);
}

std::map<int, Line> run(const Options& options, WindowOptions::Mode mode, const char* name,
                        std::FILE* csv) {
  testing::WalkOptions world;
  world.landmarks = 20;
  WindowOptions window = options.window;
  window.mode = mode;
  const int steps =
      mode == WindowOptions::Mode::kFull ? std::min(options.full, options.steps) : options.steps;
  std::map<int, Line> lines;
  for (int r = 0; r < options.runs; ++r) {
    bench::Stopwatch watch;
    double before = 0.0, stretch = 0.0;
    testing::walk<SE2>(window, world, steps, options.seed + static_cast<std::uint64_t>(r),
                       [&](int t, const WindowSmoother& smoother, const testing::PoseError& error) {
                         const int step = t + 1;
                         int next = step;
                         while (!is_printed(next)) ++next;
                         Line& line = lines[next];
                         line.nees += error.nees;
                         line.squares += error.distance * error.distance;
                         line.heading_squares += error.angle * error.angle;
                         line.count += 1.0;
                         if (step % kStretch == 0) {
                           const double now = watch.elapsed().cpu;
                           stretch = (now - before) / kStretch;
                           before = now;
                           if (csv != nullptr && r == 0)
                             std::fprintf(csv, "%s,%d,%g\n", name, step, 1e6 * stretch);
                         }
                         if (!is_printed(step)) return;
                         line.ms += 1e3 * stretch / options.runs;
                         line.bytes += double(smoother.smoother().memory().bytes) / options.runs;
                         line.states += double(smoother.smoother().values().size()) / options.runs;
                         line.divergence += smoother.divergence() / options.runs;
                       });
  }
  return lines;
}

void print(const Options& options) {
  std::FILE* csv = options.csv.empty() ? nullptr : std::fopen(options.csv.c_str(), "w");
  if (!options.csv.empty() && csv == nullptr) throw Error(options.csv + ": cannot be written");
  if (csv != nullptr) std::fprintf(csv, "graph,poses,cpu_us\n");
  std::printf("%-8s %8s %12s %10s %10s %7s %9s %10s\n", "mode", "steps", "[ms/step]", "[MB]",
              "variables", "NEES", "rms [m]", "rms [rad]");
  for (const auto& [name, mode] : {std::pair{"bounded", WindowOptions::Mode::kBounded},
                                   {"full", WindowOptions::Mode::kFull}}) {
    for (const auto& [step, line] : run(options, mode, name, csv)) {
      if (line.ms == 0.0) continue;  // not reached
      std::printf("%-8s %8d %12.3f %10.2f %10.0f %7.3f %9.4f %10.4f\n", name, step, line.ms,
                  1e-6 * line.bytes, line.states, line.nees / line.count,
                  std::sqrt(line.squares / line.count),
                  std::sqrt(line.heading_squares / line.count));
      std::fflush(stdout);
    }
  }
  if (csv != nullptr) std::fclose(csv);
}

void declare(CLI::App& app, Options& o) {
  app.option_defaults()->always_capture_default();
  app.add_option("--steps", o.steps, "of the window");
  app.add_option("--full", o.full, "of full smoothing");
  app.add_option("--runs", o.runs, "that means are over");
  app.add_option("--seed", o.seed, "of the first run");
  app.add_option("--complete", o.window.complete, "as [solver] complete");
  app.add_option("--sightings", o.window.sightings, "as [solver] sightings");
  app.add_option("--csv", o.csv, "file for all that is printed");
}

}  // namespace
}  // namespace hybrid

int main(int argc, char** argv) try {
  CLI::App app("What a keyframe costs in a window that the place bounds, and how good it is");
  hybrid::Options options;
  hybrid::declare(app, options);
  CLI11_PARSE(app, argc, argv);
  hybrid::print(options);
  return EXIT_SUCCESS;
} catch (const std::exception& e) {
  std::fprintf(stderr, "bench-bounded: %s\n", e.what());
  return EXIT_FAILURE;
}
