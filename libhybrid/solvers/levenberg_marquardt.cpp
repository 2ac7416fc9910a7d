// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, the hybrid mapping authors
#include "libhybrid/solvers/levenberg_marquardt.h"

#include <algorithm>
#include <chrono>
#include <cmath>

#include "libhybrid/solvers/convergence.h"
#include "libhybrid/solvers/null_space.h"

namespace hybrid {
namespace {

constexpr double kFirstDamping = 1e-4;  ///< after a Gauss-Newton step that failed
constexpr double kSmallestDamping = 1e-9;
constexpr double kLargestDamping = 1e14;

/// Damping by the agreement between predicted and actual decrease (Nielsen, 1999, with a
/// Gauss-Newton mode below kSmallestDamping).
class Damping {
 public:
  explicit Damping(double initial, double least)
      : value_(std::max(initial, least)), least_(least) {}
  double value() const { return value_; }
  bool exhausted() const { return value_ > kLargestDamping; }
  /// Keeps a singular system solvable from now on.
  void hold_above(double least) {
    least_ = least;
    value_ = std::max(value_, least);
  }
  void accept(double gain) {
    const double t = 2.0 * gain - 1.0;
    value_ *= std::max(0.1, 1.0 - t * t * t);
    growth_ = 2.0;
    if (value_ < kSmallestDamping) value_ = 0.0;
    value_ = std::max(value_, least_);
  }
  void reject() {
    value_ = std::max(value_ * growth_, kFirstDamping);
    growth_ *= 2.0;
  }

 private:
  double value_;
  double least_;
  double growth_ = 2.0;
};

class LevenbergMarquardt {
 public:
  LevenbergMarquardt(Problem& problem, Problem::State& state, const SolverOptions& options)
      : problem_(problem),
        state_(state),
        options_(options),
        damping_(options.initial_damping, 0.0),
        step_(problem.system().scalars()) {}

  SolverReport run() {
    double cost = problem_.linearize(state_);
    report_.costs.push_back(cost);
    if (!std::isfinite(cost)) return finish(SolverStatus::kNotFinite);
    problem_.assemble();
    while (report_.iterations < options_.max_iterations) {
      if (gradient_norm(problem_.system()) <= options_.gradient) {
        return finish(SolverStatus::kConverged);
      }
      if (!compute_step()) {
        if (damping_.exhausted()) return finish(SolverStatus::kStalled);
        continue;
      }
      const double predicted = predicted_decrease();
      const bool tiny = step_norm(problem_.system(), step_) <= options_.step ||
                        predicted <= kNegligibleDecrease * cost;
      problem_.retract(state_, step_.data(), trial_);
      const double trial_cost = problem_.linearize(trial_);
      if (trial_cost < cost) {
        const double decrease = cost - trial_cost;
        state_.swap(trial_);
        cost = trial_cost;
        report_.costs.push_back(cost);
        if (tiny || decrease <= options_.relative_decrease * cost) {
          return finish(SolverStatus::kConverged);
        }
        problem_.assemble();
        damping_.accept(decrease / predicted);
      } else {
        if (tiny || trial_cost == cost) return finish(SolverStatus::kConverged);
        damping_.reject();
        if (damping_.exhausted()) return finish(SolverStatus::kStalled);
      }
    }
    return finish(SolverStatus::kIterationLimit);
  }

 private:
  /// Damping that stays once the system was found singular.
  static constexpr double kSingularDamping = 1e-6;

  /// Solves (H + damping D) step = -g; false where the matrix is not positive definite.
  bool compute_step() {
    NormalEquations& system = problem_.system();
    ++report_.iterations;
    if (damping_.value() == 0.0) {
      report_.under_constrained = factorize_undamped(problem_);
      if (!report_.under_constrained.empty()) {
        damping_.hold_above(kSingularDamping);
        return false;
      }
    } else if (problem_.factorize(damping_.value()) >= 0) {
      damping_.reject();
      return false;
    }
    const std::vector<double>& g = system.gradient();
    std::transform(g.begin(), g.end(), step_.begin(), [](double x) { return -x; });
    system.solve(step_.data());
    return true;
  }

  double predicted_decrease() const {
    const NormalEquations& system = problem_.system();
    double sum = 0.0;
    for (std::size_t i = 0; i < step_.size(); ++i) {
      sum += step_[i] * (damping_.value() * system.diagonal()[i] * step_[i] - system.gradient()[i]);
    }
    return 0.5 * sum;
  }

  SolverReport finish(SolverStatus status) {
    finish_report(status, report_);
    return std::move(report_);
  }

  Problem& problem_;
  Problem::State& state_;
  const SolverOptions& options_;
  Damping damping_;
  std::vector<double> step_;
  Problem::State trial_;
  SolverReport report_;
};

}  // namespace

SolverReport levenberg_marquardt(Problem& problem, Problem::State& state,
                                 const SolverOptions& options) {
  const auto start = std::chrono::steady_clock::now();
  SolverReport report = LevenbergMarquardt(problem, state, options).run();
  report.seconds = seconds_since(start);
  return report;
}

SolverResult levenberg_marquardt(const HybridGraph& graph, const Estimate& initial,
                                 const SolverOptions& options) {
  return solve_graph(graph, initial, options,
                     [](auto&... args) { return levenberg_marquardt(args...); });
}

}  // namespace hybrid
