// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, the hybrid mapping authors
#include "libhybrid/solvers/starts.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <map>
#include <utility>

#include "libhybrid/core/chi_square.h"
#include "libhybrid/core/elapsed.h"
#include "libhybrid/core/infinity.h"
#include "libhybrid/linear/information_pattern.h"
#include "libhybrid/solvers/chordal.h"
#include "libhybrid/solvers/levenberg_marquardt.h"

namespace hybrid {
namespace {

/// Iterations before starts are compared. In the basin of a minimum Gauss-Newton converges in about
/// as many.
constexpr int kTrialIterations = 5;
constexpr double kFalseAlarms = 1e-3;
/// Two objectives that differ by less than this share of the cost are those of one minimum.
constexpr double kSameMinimum = 1e-4;

/// An unfinished solve from one start.
struct Run {
  Problem::State state;
  SolverReport report;

  double cost() const {
    const double cost = report.final_cost();
    return std::isfinite(cost) ? cost : kInfinity;
  }
  bool may_go_on() const { return report.status == SolverStatus::kIterationLimit; }
};

/// Continues a run for at most this many iterations.
void advance(Problem& problem, Run& run, SolverOptions options, int iterations) {
  options.max_iterations = iterations;
  const SolverReport before = std::move(run.report);
  if (!before.costs.empty()) options.initial_damping = before.damping;
  run.report = levenberg_marquardt(problem, run.state, options);
  if (before.costs.empty()) return;
  SolverReport& report = run.report;
  report.iterations += before.iterations;
  report.costs.insert(report.costs.begin(), before.costs.begin(), before.costs.end() - 1);
}

/// The index of the run of least cost; runs.size() if that run has ended.
std::size_t most_promising(const std::vector<Run>& runs) {
  std::size_t best = 0;
  for (std::size_t i = 1; i < runs.size(); ++i) {
    if (runs[i].cost() < runs[best].cost()) best = i;
  }
  return runs[best].may_go_on() ? best : runs.size();
}

/// How many linear systems the options allow, and how many of them before starts are compared: half
/// of them at most.
struct Allowance {
  long systems = std::numeric_limits<long>::max();
  int trial = kTrialIterations;
};

Allowance allowance(const HybridGraph& graph, std::size_t starts, const SolverOptions& options) {
  Allowance allowed;
  allowed.trial = std::min(kTrialIterations, options.max_iterations);
  if (options.max_operations <= 0) return allowed;
  const double each = order_blocks(information_pattern(graph, {})).flops;
  const double systems = std::clamp(options.max_operations / std::max(1.0, each), 1.0, 1e9);
  allowed.systems = static_cast<long>(systems);
  const long half = std::max(1L, allowed.systems / (2 * static_cast<long>(starts)));
  allowed.trial = static_cast<int>(std::min<long>(allowed.trial, half));
  return allowed;
}

/// See is_explained_by_noise in the header; `scalars` is the number of scalar unknowns.
bool are_explained_by_noise(const std::vector<FactorCost>& costs, int scalars) {
  double sum = 0.0;
  int rows = 0;
  std::map<int, double> limits;  // of the squared norm of a factor, by its rows
  for (const FactorCost& factor : costs) {
    auto limit = limits.find(factor.rows);
    if (limit == limits.end()) {
      const double quantile =
          chi_square_quantile(1.0 - kFalseAlarms / double(costs.size()), factor.rows);
      limit = limits.emplace(factor.rows, quantile).first;
    }
    if (!(2.0 * factor.cost <= limit->second)) return false;
    sum += 2.0 * factor.cost;
    rows += factor.rows;
  }
  const int degrees = std::max(1, rows - scalars);
  return sum <= chi_square_quantile(1.0 - kFalseAlarms, degrees);
}

/// The factors in force under the assignment of an estimate, without weak components.
std::vector<ContinuousFactorPtr> factors_in_force(const HybridGraph& graph,
                                                  const Assignment& assignment) {
  std::vector<ContinuousFactorPtr> factors;
  graph.continuous().for_each(
      [&](Handle, const ContinuousFactorPtr& factor) { factors.push_back(factor); });
  graph.hybrid().for_each([&](Handle, const HybridFactorPtr& factor) {
    const Component component = factor->given(assignment);
    if (component.factor != nullptr && !component.weak) {
      factors.emplace_back(factor, component.factor);
    }
  });
  return factors;
}

/// Whether any of the variables of `b`, which are those of `a`, has another value there.
bool differ(const Values& a, const Values& b) {
  const std::vector<Key> keys = b.keys();
  return std::any_of(keys.begin(), keys.end(), [&](Key key) {
    const double* x = b.data(key);
    return !std::equal(x, x + b.type(key).size, a.data(key));
  });
}

}  // namespace

bool is_explained_by_noise(const Problem& problem, const Problem::State& state) {
  return are_explained_by_noise(problem.factor_costs(state), problem.system().scalars());
}

StartsResult solve_from_starts(const HybridGraph& graph, const std::vector<Start>& starts,
                               const SolverOptions& options) {
  if (starts.empty()) throw Error("nowhere to start from: give at least one start");
  const auto begin = std::chrono::steady_clock::now();
  Values values = starts.front().make();
  Problem problem(graph, values, {}, options.threads, WeakComponents::kUncoupled,
                  options.elimination);
  const double analysis = seconds_since(begin);
  StartsResult result;
  std::vector<Run> runs;
  const Allowance allowed = allowance(graph, starts.size(), options);
  long systems = 0;  // solved so far
  for (const Start& start : starts) {
    runs.push_back({problem.load(runs.empty() ? values : start.make()), {}});
    advance(problem, runs.back(), options, allowed.trial);
    systems += runs.back().report.iterations;
    result.trials.push_back({start.name});
    if (runs.size() == 1 && is_explained_by_noise(problem, runs.front().state)) break;
  }
  for (std::size_t i = most_promising(runs); i < runs.size(); i = most_promising(runs)) {
    const int before = runs[i].report.iterations;
    result.met_operations = systems >= allowed.systems;
    if (before >= options.max_iterations || result.met_operations) break;
    advance(problem, runs[i], options,
            static_cast<int>(
                std::min<long>(options.max_iterations - before, allowed.systems - systems)));
    systems += runs[i].report.iterations - before;
  }
  int iterations = 0;
  for (std::size_t i = 0; i < runs.size(); ++i) {
    result.trials[i].cost = runs[i].cost();
    result.trials[i].iterations = runs[i].report.iterations;
    iterations += runs[i].report.iterations;
    if (runs[i].cost() < runs[result.won].cost()) result.won = i;
  }
  result.report = std::move(runs[result.won].report);
  problem.store(runs[result.won].state, values);
  result.values = std::move(values);
  result.report.iterations = iterations;
  result.report.analysis_seconds = analysis;
  result.report.seconds = seconds_since(begin);
  return result;
}

std::vector<Start> pose_graph_starts(const PoseGraph& graph,
                                     const std::vector<ContinuousFactorPtr>& factors,
                                     const std::string& name, const Values& initial) {
  std::vector<Start> starts{{name, [&initial] { return initial; }}};
  const auto add = [&](const std::string& other, std::function<Values()> make) {
    if (other != name) starts.push_back({other, std::move(make)});
  };
  add("odometry", [&graph] { return initialize_from_odometry(graph); });
  add("chordal", [&] { return chordal_initialization(factors, initial); });
  add("tree", [&graph] { return initialize_from_tree(graph); });
  return starts;
}

Values pose_graph_start(const PoseGraph& graph, const std::string& name) {
  if (name == "tree") return initialize_from_tree(graph);
  Values odometry = initialize_from_odometry(graph);
  if (name == "odometry") return odometry;
  if (name != "chordal") throw Error("there is no start '" + name + "'");
  Values values = chordal_initialization(to_factors(graph, odometry), odometry);
  move_to_map(graph, values);
  return values;
}

ChordalTrial try_chordal_start(const HybridGraph& graph, const Estimate& solved,
                               const AlternatingOptions& options) {
  ChordalTrial trial;
  const std::vector<ContinuousFactorPtr> factors = factors_in_force(graph, solved.assignment);
  std::vector<FactorCost> costs;
  for (const ContinuousFactorPtr& factor : factors) {
    costs.push_back({factor->cost(solved.values), factor->rows()});
  }
  int scalars = 0;
  for (const Key key : solved.values.keys()) scalars += solved.values.type(key).dim;
  if (scalars == 0 || are_explained_by_noise(costs, scalars)) return trial;
  Estimate estimate{chordal_initialization(factors, solved.values), solved.assignment};
  trial.tried = differ(solved.values, estimate.values);
  if (!trial.tried) return trial;
  Problem problem(graph, solved.values, solved.assignment, options.continuous.threads,
                  WeakComponents::kUncoupled, options.continuous.elimination);
  Problem::State state = problem.load(solved.values);
  const double cost = problem.cost(state);
  const double limit = cost + problem.constant() - kSameMinimum * cost;
  state = problem.load(estimate.values);
  AlternatingOptions few = options;
  few.max_iterations = std::min(2, options.max_iterations);
  few.continuous_iterations = std::min(kTrialIterations, options.continuous_iterations);
  trial.objective = alternate(graph, problem, state, estimate.assignment, few).objective;
  if (!(trial.objective < limit)) return trial;
  trial.objective = alternate(graph, problem, state, estimate.assignment, options).objective;
  problem.store(state, estimate.values);
  trial.better = std::move(estimate);
  return trial;
}

}  // namespace hybrid
