// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, the hybrid mapping authors

// Consistency of windows: how well the covariance of the newest pose matches its error over
// simulated runs, by full smoothing, with a fixed lag and as a filter.
//
//   bench-consistency [--runs N] [--seed N] [--noise F] [--world plane|space|ranges] [--lag N]
//                     [--steps N]
//
// NEES is the normalised estimation error squared per degree of freedom: 1 if the covariance is
// right, larger if it is too small. It is given for the last pose, with its standard error over the
// runs, and for the newest pose over all steps.

#include <CLI/CLI.hpp>
#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <exception>
#include <string>
#include <utility>

#include "bench/stopwatch.h"
#include "tests/support/consistency.h"

namespace hybrid {
namespace {

using testing::PoseError;
using testing::WalkOptions;

struct Options {
  int runs = 100, lag = 10, steps = 150;
  std::uint64_t seed = 1;
  std::string world = "plane";
  WalkOptions walk;
};

/// Sums over runs.
struct Sum {
  double count = 0.0, sum = 0.0, squares = 0.0;

  void add(double x) {
    count += 1.0;
    sum += x;
    squares += x * x;
  }
  double mean() const { return sum / count; }
  double root() const { return std::sqrt(squares / count); }
  double standard_error() const {
    return std::sqrt(std::max(0.0, squares / count - mean() * mean()) / count);
  }
};

struct Score {
  Sum last, last_heading, newest, newest_heading, distance, angle, variables;
};

template <class Pose>
Score score(const Options& options, WindowOptions::Mode mode) {
  WindowOptions window;
  window.mode = mode;
  window.lag = options.lag;
  Score s;
  for (int r = 0; r < options.runs; ++r) {
    const std::uint64_t seed = options.seed + static_cast<std::uint64_t>(r);
    testing::walk<Pose>(window, options.walk, options.steps, seed,
                        [&](int t, const WindowSmoother& smoother, const PoseError& error) {
                          s.newest.add(error.nees);
                          s.newest_heading.add(error.heading_nees);
                          s.distance.add(error.distance);
                          s.angle.add(error.angle);
                          if (t + 1 < options.steps) return;
                          s.last.add(error.nees);
                          s.last_heading.add(error.heading_nees);
                          s.variables.add(double(smoother.smoother().values().size()));
                        });
  }
  return s;
}

void print(const Options& options) {
  const std::pair<const char*, WindowOptions::Mode> modes[] = {
      {"full", WindowOptions::Mode::kFull},
      {"fixed lag", WindowOptions::Mode::kFixedLag},
      {"filter", WindowOptions::Mode::kFilter}};
  std::printf("%-9s  %-22s  %-13s  %-18s  %-9s  %s\n", "", "NEES of last pose", "of newest",
              "rms error", "variables", "cpu");
  std::printf("%-9s  %-13s  %-7s  %-5s  %-6s  %-7s  %-9s  %-9s  %s\n", "mode", "pose", "heading",
              "pose", "heading", "[m]", "[rad]", "at the end", "[ms/step]");
  for (const auto& [name, mode] : modes) {
    const bench::Stopwatch watch;
    const Score s =
        options.world == "space" ? score<SE3>(options, mode) : score<SE2>(options, mode);
    std::printf("%-9s  %5.3f +- %4.2f  %7.3f  %5.3f  %7.3f  %7.3f  %9.4f  %10.0f  %.3f\n", name,
                s.last.mean(), s.last.standard_error(), s.last_heading.mean(), s.newest.mean(),
                s.newest_heading.mean(), s.distance.root(), s.angle.root(), s.variables.mean(),
                1e3 * watch.elapsed().cpu / (options.runs * options.steps));
    std::fflush(stdout);
  }
}

void declare(CLI::App& app, Options& o) {
  app.option_defaults()->always_capture_default();
  app.add_option("--runs", o.runs, "that means are over");
  app.add_option("--seed", o.seed, "of the first run");
  app.add_option("--noise", o.walk.noise, "true noise of the sensors over the stated one");
  app.add_option("--world", o.world, "plane, space or ranges")
      ->check(CLI::IsMember({"plane", "space", "ranges"}));
  app.add_option("--lag", o.lag, "of the window, in steps");
  app.add_option("--steps", o.steps, "of a run");
}

void enter_world(Options& o) {
  if (o.world == "space") {
    o.walk.landmarks = 60;
    o.walk.spread = 6.0;
  }
  if (o.world == "ranges") o.walk.sensor = testing::Sensor::kRange;
}

}  // namespace
}  // namespace hybrid

int main(int argc, char** argv) try {
  CLI::App app("How well the covariance of the newest pose matches its error, by kind of window");
  hybrid::Options options;
  hybrid::declare(app, options);
  CLI11_PARSE(app, argc, argv);
  hybrid::enter_world(options);
  hybrid::print(options);
  return EXIT_SUCCESS;
} catch (const std::exception& e) {
  std::fprintf(stderr, "bench-consistency: %s\n", e.what());
  return EXIT_FAILURE;
}
