// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, the hybrid mapping authors

// Landmark-heavy graphs: Schur complement compared with plain sparse Cholesky and with Ceres'
// SPARSE_SCHUR, on the same simulated problem with the same residuals, in one run.
#include <ceres/ceres.h>

#include <CLI/CLI.hpp>
#include <algorithm>
#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <functional>
#include <iostream>
#include <string>
#include <vector>

#include "bench/ceres_factor.h"
#include "bench/stopwatch.h"
#include "libhybrid/factors/bearing_range.h"
#include "libhybrid/factors/between.h"
#include "libhybrid/factors/prior.h"
#include "libhybrid/io/write_file.h"
#include "libhybrid/linear/cholesky.h"
#include "libhybrid/solvers/levenberg_marquardt.h"
#include "tests/support/random.h"

namespace hybrid {
namespace {

using bench::Stopwatch;
using testing::Random;

constexpr int kThreads = 2;
constexpr int kLapPoses = 125;  // poses of a lap; landmarks are seen in every lap

struct Settings {
  int poses = 500, landmarks = 50000, sightings = 10, repeats = 3;
  std::string json;
};

struct Case {
  HybridGraph graph;
  Estimate initial;
};

/// Laps of a robot on a hilly circle. Each landmark has `sightings` sightings, from near poses of
/// any lap.
Case simulate(const Settings& settings) {
  Case c;
  Random random(1);
  const auto pose = [&](int i) {
    const double turn = 2.0 * M_PI * i / kLapPoses;
    return SE3(Eigen::Vector3d(40 * std::cos(turn), 40 * std::sin(turn), std::sin(3 * turn)),
               SO3::exp(Eigen::Vector3d(0, 0, turn + M_PI / 2)));
  };
  const Noise step =
      Noise::diagonal((Eigen::VectorXd(6) << .02, .02, .02, .002, .002, .002).finished());
  const Noise sight = Noise::diagonal(Eigen::Vector3d(0.05, 0.005, 0.005));
  for (int i = 0; i < settings.poses; ++i) {
    const SE3 start = pose(i) * SE3(random.vector<3>(0.1), SO3::exp(random.vector<3>(0.01)));
    c.initial.values.insert(Key('x', i), i == 0 ? pose(0) : start);
    if (i == 0) c.graph.emplace<Prior<SE3>>(Key('x', 0), pose(0), Noise::isotropic(6, 1e-3));
    if (i == 0) continue;
    const SE3 noisy = pose(i - 1).inverse() * pose(i) *
                      SE3(random.vector<3>(0.02), SO3::exp(random.vector<3>(0.002)));
    c.graph.emplace<Between<SE3>>(Key('x', i - 1), Key('x', i), noisy, step);
  }
  for (int l = 0; l < settings.landmarks; ++l) {
    const int near = random.below(settings.poses);
    const Eigen::Vector3d p = pose(near) * random.vector<3>(6.0);
    c.initial.values.insert(Key('l', l), Eigen::Vector3d(p + random.vector<3>(0.2)));
    std::vector<int> seen;
    while (static_cast<int>(seen.size()) < std::min(settings.sightings, settings.poses / 4)) {
      const int lap = random.below(std::max(1, settings.poses / kLapPoses));
      const int i =
          (near + lap * kLapPoses + random.below(13) - 6 + settings.poses) % settings.poses;
      if (std::find(seen.begin(), seen.end(), i) != seen.end()) continue;
      seen.push_back(i);
      Eigen::Vector3d z = to_polar(Eigen::Vector3d(pose(i).inverse() * p));
      z += Eigen::Vector3d(random.normal(0.05), random.normal(0.005), random.normal(0.005));
      z[0] = std::abs(z[0]);
      c.graph.emplace<BearingRange3>(Key('x', i), Key('l', l), z, sight);
    }
  }
  return c;
}

struct Outcome {
  bench::Time time;
  double cost = 0.0;
  int iterations = 0;
};

/// Times everything from the graph to the values, compilation and ordering included.
Outcome run_ours(const Case& c, Elimination elimination) {
  SolverOptions options;
  options.threads = kThreads;
  options.elimination = elimination;
  const Stopwatch watch;
  const SolverResult result = levenberg_marquardt(c.graph, c.initial, options);
  return {watch.elapsed(), result.report.final_cost(), result.report.iterations};
}

/// Times Solve only, without building the problem of Ceres.
Outcome run_ceres(const Case& c) {
  Values values = c.initial.values;
  ceres::Problem problem;
  auto* ordering = new ceres::ParameterBlockOrdering;
  for (Key key : values.keys()) {
    const VariableType type = values.type(key);
    double* x = values.data(values.slot(key));
    if (type.kind == VariableKind::kVector) {
      problem.AddParameterBlock(x, type.size);
      ordering->AddElementToGroup(x, 0);
    } else {
      problem.AddParameterBlock(x, type.size, new bench::Retraction(type));
      ordering->AddElementToGroup(x, 1);
    }
  }
  c.graph.continuous().for_each([&](Handle, const ContinuousFactorPtr& factor) {
    std::vector<double*> x;
    for (Key key : factor->keys()) x.push_back(values.data(values.slot(key)));
    problem.AddResidualBlock(new bench::CeresFactor(factor), nullptr, x);
  });
  ceres::Solver::Options options;
  options.linear_solver_type = ceres::SPARSE_SCHUR;
  options.sparse_linear_algebra_library_type = ceres::SUITE_SPARSE;
  options.linear_solver_ordering.reset(ordering);
  options.num_threads = kThreads;
  options.max_num_iterations = 100;
  options.function_tolerance = 1e-6;
  options.logging_type = ceres::SILENT;
  // Like ours, it starts with Gauss-Newton steps rather than a small trust region.
  options.initial_trust_region_radius = 1e16;
  ceres::Solver::Summary summary;
  const Stopwatch watch;
  ceres::Solve(options, &problem, &summary);
  return {watch.elapsed(), summary.final_cost, static_cast<int>(summary.iterations.size()) - 1};
}

/// One linear system: factorisation and substitution.
struct LinearTimes {
  bench::Time analysis, numeric;
};

LinearTimes run_linear(const Case& c, Elimination elimination, std::vector<double>& step) {
  LinearTimes times;
  const Stopwatch analysis;
  Problem problem(c.graph, c.initial.values, {}, kThreads, WeakComponents::kUncoupled, elimination);
  times.analysis = analysis.elapsed();
  problem.linearize(problem.load(c.initial.values));
  problem.assemble();
  const Stopwatch numeric;
  problem.factorize(0.0);
  std::vector<double> x = problem.system().gradient();
  problem.system().solve(x.data());
  times.numeric = numeric.elapsed();
  step.clear();
  for (int b = 0; b < problem.block_count(); ++b) {
    const int start = problem.system().start(b);
    step.insert(step.end(), x.begin() + start, x.begin() + start + problem.system().dim(b));
  }
  return times;
}

/// Times CHOLMOD on the plain system, in its own fill-reducing order.
bench::Time run_cholmod(const Case& c) {
  Problem problem(c.graph, c.initial.values, {}, kThreads, WeakComponents::kUncoupled,
                  Elimination::kPlain);
  problem.linearize(problem.load(c.initial.values));
  problem.assemble();
  Cholesky cholmod(problem.system().matrix());
  const Stopwatch numeric;
  cholmod.factorize(problem.system().matrix());
  std::vector<double> x = problem.system().gradient();
  cholmod.solve(x.data());
  return numeric.elapsed();
}

std::string text(const char* name, const bench::Time& time) {
  char line[160];
  std::snprintf(line, sizeof line, "\"%s_s\": %.4f, \"%s_cpu_s\": %.4f", name, time.wall, name,
                time.cpu);
  return line;
}

/// The result with the least processor time.
template <class Run>
auto best_of(int repeats, const Run& run) {
  auto best = run();
  for (int k = 1; k < repeats; ++k) {
    auto other = run();
    if (other.cpu < best.cpu) best = other;
  }
  return best;
}

std::string measure(const Settings& settings) {
  const Case c = simulate(settings);
  std::vector<double> schur_step, plain_step;
  const auto linear = [&](Elimination elimination, std::vector<double>& step, bool analysis) {
    return best_of(settings.repeats, [&] {
      const LinearTimes times = run_linear(c, elimination, step);
      return analysis ? times.analysis : times.numeric;
    });
  };
  std::string line = "{\"poses\": " + std::to_string(settings.poses) +
                     ", \"landmarks\": " + std::to_string(settings.landmarks) + ",\n ";
  line += text("schur_linear", linear(Elimination::kSchur, schur_step, false)) + ",\n ";
  line += text("plain_linear", linear(Elimination::kPlain, plain_step, false)) + ",\n ";
  line +=
      text("cholmod_linear", best_of(settings.repeats, [&] { return run_cholmod(c); })) + ",\n ";
  line += text("schur_analysis", linear(Elimination::kSchur, schur_step, true)) + ",\n ";
  line += text("plain_analysis", linear(Elimination::kPlain, plain_step, true)) + ",\n ";
  double difference = 0.0, size = 0.0;
  for (std::size_t i = 0; i < schur_step.size(); ++i) {
    difference = std::max(difference, std::abs(schur_step[i] - plain_step[i]));
    size = std::max(size, std::abs(plain_step[i]));
  }
  const auto solved = [&](const char* name, const std::function<Outcome()>& run) {
    Outcome last;
    const bench::Time time = best_of(settings.repeats, [&] {
      last = run();
      return last.time;
    });
    char more[120];
    std::snprintf(more, sizeof more, ", \"%s_iterations\": %d, \"%s_cost\": %.9g", name,
                  last.iterations, name, last.cost);
    return text(name, time) + more + ",\n ";
  };
  line += solved("solve_automatic", [&] { return run_ours(c, Elimination::kAutomatic); });
  line += solved("solve_plain", [&] { return run_ours(c, Elimination::kPlain); });
  line += solved("solve_ceres", [&] { return run_ceres(c); });
  char last[80];
  std::snprintf(last, sizeof last, "\"step_difference\": %.3g}", difference / size);
  return line + last;
}

void run(const Settings& settings) {
  const std::string line = measure(settings);
  std::cout << line << std::endl;
  if (!settings.json.empty()) write_file(settings.json, "[" + line + "]\n");
}

}  // namespace
}  // namespace hybrid

int main(int argc, char** argv) try {
  CLI::App app(
      "Elimination of landmarks first, compared with none and with Ceres: wall and processor times "
      "of "
      "the run with the least processor time");
  hybrid::Settings settings;
  const auto number = [&](const char* name, int& value, const char* what) {
    app.add_option(name, value, what)->check(CLI::PositiveNumber)->capture_default_str();
  };
  number("--poses", settings.poses, "Poses");
  number("--landmarks", settings.landmarks, "Landmarks");
  number("--sightings", settings.sightings, "Sightings of each landmark");
  number("--repeats", settings.repeats, "Runs of each");
  app.add_option("--json", settings.json, "Write the figures here, too");
  CLI11_PARSE(app, argc, argv);
  hybrid::run(settings);
  return EXIT_SUCCESS;
} catch (const std::exception& e) {
  std::fprintf(stderr, "bench-schur: %s\n", e.what());
  return EXIT_FAILURE;
}
