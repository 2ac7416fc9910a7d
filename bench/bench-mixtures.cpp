// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, the hybrid mapping authors

// Max-mixtures, sum-mixtures and the alternation on planar pose graphs with false closures by the
// protocol of section V-A, from odometry: error relative to the optimum of the clean graph.
#include <Eigen/Geometry>
#include <cstdio>
#include <cstdlib>
#include <ctime>
#include <exception>
#include <functional>
#include <string>
#include <utility>
#include <vector>

#include "libhybrid/baselines/least_squares.h"
#include "libhybrid/baselines/max_mixture.h"
#include "libhybrid/baselines/soft_mixture.h"
#include "libhybrid/io/read_graph.h"
#include "libhybrid/pose_graph/false_closures.h"
#include "libhybrid/solvers/alternating.h"

namespace hybrid {
namespace {

constexpr int kSeeds = 5;
constexpr int kFirstSeed = 101;

/// The alternation of the paper on the graph of eq. 16, with all closures accepted at first.
RobustResult solve_alternating(const RobustProblem& problem) {
  const HybridGraph graph = mixture_graph(problem);
  const std::vector<bool> all(problem.closures.size(), true);
  const AlternatingResult found = alternate(graph, {problem.initial, to_assignment(all)});
  RobustResult result;
  result.values = found.estimate.values;
  std::vector<bool> accepted;
  for (std::size_t k = 0; k < all.size(); ++k) {
    accepted.push_back(found.estimate.assignment.at(closure_switch(k).key) == 0);
  }
  finish(problem, accepted, {}, result);
  return result;
}

/// Mean distance after rigid alignment [m].
double error(const Values& found, const Values& truth) {
  Eigen::Matrix2Xd a(2, truth.size()), b(2, truth.size());
  Eigen::Index i = 0;
  for (Key key : truth.keys()) {
    a.col(i) = found.at<SE2>(key).translation();
    b.col(i++) = truth.at<SE2>(key).translation();
  }
  const Eigen::Matrix3d T = Eigen::umeyama(a, b, false);
  const Eigen::Matrix2Xd moved = (T.topLeftCorner<2, 2>() * a).colwise() + T.col(2).head<2>();
  return (moved - b).colwise().norm().mean();
}

struct Method {
  const char* name;
  std::function<RobustResult(const RobustProblem&)> solve;
};

void run(const std::string& path) {
  const std::vector<Method> methods = {
      {"alternation", [](const RobustProblem& p) { return solve_alternating(p); }},
      {"max-mixture", [](const RobustProblem& p) { return solve_max_mixture(p); }},
      {"sum-mixture", [](const RobustProblem& p) { return solve_soft_mixture(p); }}};
  const PoseGraph clean = read_graph(path);
  const Values start = initialize_from_odometry(clean);
  const Values truth = solve_lm(to_robust_problem(clean, start)).values;
  const std::size_t closures = to_robust_problem(clean, start).closures.size();
  for (double rate : {0.1, 0.3, 0.5}) {
    for (const Method& method : methods) {
      double ate = 0.0, worst = 0.0, found = 0.0, real = 0.0, both = 0.0, seconds = 0.0;
      for (int seed = kFirstSeed; seed < kFirstSeed + kSeeds; ++seed) {
        const RobustProblem problem = to_robust_problem(
            add_false_closures(clean, rate, static_cast<std::uint64_t>(seed)), start);
        const std::clock_t before = std::clock();
        const RobustResult result = method.solve(problem);
        seconds += double(std::clock() - before) / CLOCKS_PER_SEC / kSeeds;
        const double e = error(result.values, truth);
        ate += e / kSeeds;
        worst = std::max(worst, e);
        for (std::size_t k = 0; k < result.decisions.size(); ++k) {
          found += result.decisions[k].accepted();
          real += k < closures;
          both += result.decisions[k].accepted() && k < closures;
        }
      }
      std::printf(
          "%-30s %3.0f %%  %-12s ATE mean %.3f worst %.3f m  precision %.3f recall %.3f  "
          "%.2f s\n",
          path.substr(path.rfind('/') + 1).c_str(), 100 * rate, method.name, ate, worst,
          both / found, both / real, seconds);
      std::fflush(stdout);
    }
  }
}

}  // namespace
}  // namespace hybrid

int main(int argc, char** argv) try {
  if (argc < 2) {
    std::fprintf(stderr, "usage: bench-mixtures GRAPH...  (planar, g2o or TORO)\n");
    return EXIT_FAILURE;
  }
  for (int i = 1; i < argc; ++i) hybrid::run(argv[i]);
  return EXIT_SUCCESS;
} catch (const std::exception& e) {
  std::fprintf(stderr, "bench-mixtures: %s\n", e.what());
  return EXIT_FAILURE;
}
