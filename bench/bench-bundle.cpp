// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, the hybrid mapping authors

// Bundle adjustment with unknown intrinsics, simulated: errors and standard deviations of the
// intrinsics, and what is not determined when the cameras face a wall.
#include <cmath>
#include <cstdio>
#include <exception>

#include "bench/stopwatch.h"
#include "libhybrid/marginals/observability.h"
#include "libhybrid/solvers/levenberg_marquardt.h"
#include "tests/support/simulated_bundle.h"

namespace hybrid {
namespace {

using testing::BundleOptions;
using testing::SimulatedBundle;

constexpr int kTrials = 20;
constexpr int kEntries = 5;
constexpr const char* kNames[kEntries] = {"f", "cx", "cy", "k1", "k2"};

void around() {
  const BundleOptions options;
  double squares[kEntries] = {}, sigmas[kEntries] = {}, normalized = 0.0, seconds = 0.0;
  int observations = 0;
  for (int seed = 1; seed <= kTrials; ++seed) {
    const SimulatedBundle bundle = testing::simulate_bundle(options, seed);
    const bench::Stopwatch watch;
    const SolverResult result = levenberg_marquardt(bundle.graph, bundle.initial);
    seconds += watch.elapsed().cpu;
    observations += bundle.observations;
    const ObservedVector camera = observe_vector(bundle.graph, {result.values, {}}, Key('k', 0));
    for (int i = 0; i < kEntries; ++i) {
      const double error = camera.values[i] - options.intrinsics[i];
      squares[i] += error * error / kTrials;
      sigmas[i] += camera.sigmas[i] / kTrials;
      normalized += std::pow(error / camera.sigmas[i], 2) / (kTrials * kEntries);
    }
  }
  std::printf(
      "%d cameras around %d points, %d sightings with %g pixels of noise, %d trials, %.3f s each\n",
      options.cameras, options.points, observations / kTrials, options.pixel_noise, kTrials,
      seconds / kTrials);
  for (int i = 0; i < kEntries; ++i) {
    std::printf("  %-3s truth %8.3f start %8.3f  rms error %.3g  stated sigma %.3g\n", kNames[i],
                options.intrinsics[i], options.start[i], std::sqrt(squares[i]), sigmas[i]);
  }
  std::printf("  mean squared error over variance: %.2f (1 where the variances are right)\n",
              normalized);
}

/// Cameras that face a wall, with known directions and free positions.
void wall() {
  BundleOptions options;
  options.around = false;
  options.cameras = 8;
  const SimulatedBundle bundle = testing::simulate_bundle(options, 1);
  HybridGraph graph;
  bundle.graph.continuous().for_each([&](Handle, const ContinuousFactorPtr& factor) {
    if (factor->name() == "projection") graph.add(factor);
  });
  Eigen::VectorXd sigmas(6);
  sigmas << 1e3, 1e3, 1e3, 1e-4, 1e-4, 1e-4;
  for (int i = 0; i < options.cameras; ++i) {
    graph.emplace<Prior<SE3>>(Key('c', i), bundle.truth.at<SE3>(Key('c', i)),
                              Noise::diagonal(sigmas));
  }
  const ObservedVector camera = observe_vector(graph, {bundle.truth, {}}, Key('k', 0));
  std::printf("%d cameras that face a wall squarely\n  %s\n", options.cameras,
              camera.text({kNames, kNames + kEntries}).c_str());
}

}  // namespace
}  // namespace hybrid

int main() {
  try {
    hybrid::around();
    hybrid::wall();
    return 0;
  } catch (const std::exception& e) {
    std::fprintf(stderr, "bench-bundle: %s\n", e.what());
    return 1;
  }
}
