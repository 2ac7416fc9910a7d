// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, the hybrid mapping authors
#include "libhybrid/solvers/alternating.h"

#include <algorithm>
#include <chrono>
#include <cmath>

#include "libhybrid/core/infinity.h"
#include "libhybrid/discrete/impossible.h"
#include "libhybrid/solvers/detail/convergence.h"
#include "libhybrid/solvers/levenberg_marquardt.h"

namespace hybrid {
namespace {

class Alternation {
 public:
  Alternation(const HybridGraph& graph, Problem& problem, Problem::State& state,
              Assignment& assignment, const AlternatingOptions& options)
      : graph_(graph),
        problem_(problem),
        state_(state),
        assignment_(assignment),
        options_(options) {
    options_.continuous.max_iterations = options.continuous_iterations;
  }

  AlternatingReport run() {
    problem_.set_assignment(assignment_);
    objective_ = problem_.cost(state_) + problem_.constant();
    report_.initial_objective = objective_;
    if (std::isnan(objective_)) {
      report_.message = "the objective of the initial estimate is not a number";
      return finish(AlternatingStatus::kNotFinite);
    }
    while (report_.iterations < options_.max_iterations) {
      const double before = objective_;
      const int flips = discrete_half_step();
      if (!report_.message.empty()) return finish(AlternatingStatus::kNotFinite);
      if (report_.iterations > 0 && flips == 0 && settled())
        return finish(report_.last_solve.status);
      ++report_.iterations;
      continuous_half_step();
      const double scale = std::max(problem_.cost(state_), 1e-12);
      if (flips == 0 && settled() && before - objective_ <= options_.relative_decrease * scale) {
        return finish(report_.last_solve.status);
      }
    }
    return finish(AlternatingStatus::kIterationLimit);
  }

 private:
  /// Whether the last continuous half-step ended before its iteration limit.
  bool settled() const { return report_.last_solve.status != SolverStatus::kIterationLimit; }

  /// Eq. 8a and 9a; returns the number of variables that changed.
  int discrete_half_step() {
    const std::vector<Table> hybrid_tables = problem_.tables(state_);
    std::vector<const Table*> tables;
    tables.reserve(hybrid_tables.size() + graph_.discrete().size());
    graph_.discrete().for_each([&](Handle, const Table& table) { tables.push_back(&table); });
    for (const Table& table : hybrid_tables) tables.push_back(&table);
    Assignment proposal = assignment_;
    const DiscreteReport solved = update_assignment(tables, options_.discrete, proposal);
    report_.discrete_exact = report_.discrete_exact && solved.exact;
    if (!solved.impossible.empty()) report_.message = no_joint_value(solved.impossible);
    int flips = static_cast<int>(solved.changed.size());
    if (flips > 0) {
      problem_.set_assignment(proposal);
      const double objective = problem_.cost(state_) + problem_.constant();
      if (objective < objective_) {
        assignment_ = std::move(proposal);
        objective_ = objective;
      } else {  // a gain below rounding error is no gain
        problem_.set_assignment(assignment_);
        flips = 0;
      }
    }
    report_.half_steps.push_back({true, objective_, flips});
    return flips;
  }

  /// Eq. 8b and 9b.
  void continuous_half_step() {
    Problem::State moved = state_;
    SolverOptions options = options_.continuous;
    if (report_.iterations > 1 && !settled()) options.initial_damping = report_.last_solve.damping;
    report_.last_solve = levenberg_marquardt(problem_, moved, options);
    const double objective = problem_.cost(moved) + problem_.constant();
    if (objective <= objective_) {
      state_ = std::move(moved);
      objective_ = objective;
    }
    report_.half_steps.push_back({false, objective_, report_.last_solve.iterations});
  }

  AlternatingReport finish(AlternatingStatus status) {
    if (status == AlternatingStatus::kConverged && objective_ == kInfinity) {
      status = AlternatingStatus::kNotFinite;
      report_.message = no_joint_value({});
    }
    report_.status = status;
    report_.objective = objective_;
    report_.cost = problem_.cost(state_);
    report_.analyses = problem_.analyses();
    if (status == AlternatingStatus::kIterationLimit) {
      report_.message = "the assignment still changed, or the objective fell, after " +
                        std::to_string(report_.iterations) + " pairs of half-steps, the limit";
    } else if (report_.message.empty()) {
      report_.message = to_string(status) + " after " + std::to_string(report_.iterations) +
                        " pairs of half-steps; the last solve: " + report_.last_solve.message;
    }
    return std::move(report_);
  }

  const HybridGraph& graph_;
  Problem& problem_;
  Problem::State& state_;
  Assignment& assignment_;
  AlternatingOptions options_;
  double objective_ = 0.0;
  AlternatingReport report_;
};

}  // namespace

AlternatingReport alternate(const HybridGraph& graph, Problem& problem, Problem::State& state,
                            Assignment& assignment, const AlternatingOptions& options) {
  const auto start = std::chrono::steady_clock::now();
  AlternatingReport report = Alternation(graph, problem, state, assignment, options).run();
  report.seconds = seconds_since(start);
  return report;
}

AlternatingResult alternate(const HybridGraph& graph, const Estimate& initial,
                            const AlternatingOptions& options) {
  const auto start = std::chrono::steady_clock::now();
  AlternatingResult result{initial, {}};
  Problem problem(graph, initial.values, initial.assignment, options.continuous.threads);
  Problem::State state = problem.load(initial.values);
  result.report = alternate(graph, problem, state, result.estimate.assignment, options);
  problem.store(state, result.estimate.values);
  result.report.seconds = seconds_since(start);
  return result;
}

}  // namespace hybrid
