// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, the hybrid mapping authors
#include "libhybrid/solvers/levenberg_marquardt.h"

#include <algorithm>
#include <chrono>
#include <cmath>

#include "libhybrid/solvers/detail/convergence.h"
#include "libhybrid/solvers/null_space.h"

namespace hybrid {
namespace {

constexpr double kDampingAfterFailure = 1e-4;  ///< after a Gauss-Newton step that failed
constexpr double kSmallestDamping = 1e-9;
constexpr double kLargestDamping = 1e14;

/// Damping by the agreement between predicted and actual decrease (Nielsen, 1999, with a
/// Gauss-Newton mode below kSmallestDamping).
class Damping {
 public:
  explicit Damping(double initial) : value_(initial) {}
  double value() const { return value_; }
  /// Whether the step is the Gauss-Newton step, or the nearest to it that a singular system allows.
  bool is_least() const { return value_ == least_; }
  bool exhausted() const { return value_ > kLargestDamping; }
  /// Sets a lower bound, with which a singular system stays solvable.
  void hold_above(double least) {
    least_ = least;
    value_ = std::max(value_, least);
  }
  void release() { least_ = value_ = 0.0; }
  void accept(double gain) {
    const double t = 2.0 * gain - 1.0;
    value_ *= std::max(0.1, 1.0 - t * t * t);
    growth_ = 2.0;
    if (value_ < kSmallestDamping) value_ = 0.0;
    value_ = std::max(value_, least_);
  }
  void reject() {
    value_ = std::max({value_ * growth_, kDampingAfterFailure, suspended_});
    growth_ *= 2.0;
  }
  /// Makes the next step a Gauss-Newton step; the present damping is restored if that is rejected.
  /// Works once: false if it was done before.
  bool suspend() {
    if (suspended_ > 0.0) return false;
    suspended_ = value_;
    value_ = least_;
    return true;
  }

 private:
  double value_;
  double least_ = 0.0;
  double suspended_ = 0.0;
  double growth_ = 2.0;
};

class LevenbergMarquardt {
 public:
  LevenbergMarquardt(Problem& problem, Problem::State& state, const SolverOptions& options)
      : problem_(problem),
        state_(state),
        options_(options),
        damping_(options.initial_damping),
        step_(problem.system().scalars()) {}

  SolverReport run() {
    double cost = problem_.linearize(state_);
    report_.costs.push_back(cost);
    if (!std::isfinite(cost)) return finish(SolverStatus::kNotFinite);
    problem_.assemble();
    while (true) {
      const double gradient = gradient_norm(problem_.system());
      if (std::isnan(gradient)) return finish(SolverStatus::kNotFinite);
      if (gradient <= options_.gradient && settled()) return finish(SolverStatus::kConverged);
      if (report_.iterations >= options_.max_iterations) break;
      if (!compute_step()) {
        if (damping_.exhausted()) return finish(status_without_decrease(problem_, state_, cost));
        continue;
      }
      const double predicted = predicted_decrease();
      const double little = options_.relative_decrease * cost;
      const bool tiny = step_norm(problem_.system(), step_) <= options_.step;
      const bool last = damping_.is_least() && (tiny || (predicted >= 0.0 && predicted <= little));
      problem_.retract(state_, step_.data(), trial_);
      const double trial_cost = problem_.linearize(trial_);
      const double decrease = cost - trial_cost;
      const bool accepted = decrease > 0.0;
      if (accepted) {
        state_.swap(trial_);
        cost = trial_cost;
        report_.costs.push_back(cost);
      }
      if (last && !(decrease > little)) {
        if (settled()) return finish(SolverStatus::kConverged);
      } else {
        if (accepted) problem_.assemble();
        adapt(decrease, predicted, little);
      }
      if (damping_.exhausted()) return finish(status_without_decrease(problem_, state_, cost));
    }
    return finish(SolverStatus::kIterationLimit);
  }

 private:
  /// Least damping while the system is singular.
  static constexpr double kSingularDamping = 1e-6;

  /// Solves (H + damping D) step = -g; false if the matrix is not positive definite.
  bool compute_step() {
    NormalEquations& system = problem_.system();
    ++report_.iterations;
    if (damping_.value() == 0.0) {
      Undamped undamped = factorize_undamped(problem_);
      if (!undamped.usable) {
        damping_.hold_above(undamped.free.empty() ? kSmallestDamping : kSingularDamping);
        report_.under_constrained = std::move(undamped.free);
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

  bool settled() {
    if (is_settled(problem_, state_, report_)) return true;
    damping_.release();
    return false;
  }

  void adapt(double decrease, double predicted, double little) {
    if (!(decrease > 0.0)) return damping_.reject();
    if (decrease > little) return damping_.accept(decrease / predicted);
    // The cost hardly falls any more; only a step without damping shows by how much it could.
    if (damping_.is_least()) {
      damping_.reject();
    } else if (!damping_.suspend()) {
      damping_.accept(decrease / predicted);
    }
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
    report_.damping = damping_.value();
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
