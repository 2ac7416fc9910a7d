// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, the hybrid mapping authors
#include "libhybrid/solvers/dogleg.h"

#include <algorithm>
#include <chrono>
#include <cmath>

#include "libhybrid/solvers/detail/convergence.h"
#include "libhybrid/solvers/null_space.h"

namespace hybrid {
namespace {

constexpr double kSmallestRadius = 1e-12;  ///< relative to one standard deviation per unknown
/// Damping of a singular system.
constexpr double kSingularDamping = 1e-6;

class Dogleg {
 public:
  Dogleg(Problem& problem, Problem::State& state, const SolverOptions& options)
      : problem_(problem),
        system_(problem.system()),
        state_(state),
        options_(options),
        scale_(std::sqrt(double(std::max(system_.scalars(), 1)))),
        radius_(options.initial_radius * scale_),
        descent_(system_.scalars()),
        newton_(system_.scalars()),
        step_(system_.scalars()),
        product_(system_.scalars()) {}

  SolverReport run() {
    double cost = problem_.linearize(state_);
    report_.costs.push_back(cost);
    if (!std::isfinite(cost)) return finish(SolverStatus::kNotFinite);
    problem_.assemble();
    while (true) {
      const double gradient = gradient_norm(system_);
      if (std::isnan(gradient)) return finish(SolverStatus::kNotFinite);
      if (gradient <= options_.gradient && settled()) return finish(SolverStatus::kConverged);
      if (report_.iterations >= options_.max_iterations) break;
      ++report_.iterations;
      if (fresh_) compute_directions();
      const bool whole = choose_step();
      const double predicted = predicted_decrease();
      const double little = options_.relative_decrease * cost;
      const bool tiny = step_norm(system_, step_) <= options_.step;
      const bool last = whole && (tiny || (predicted >= 0.0 && predicted <= little));
      problem_.retract(state_, step_.data(), trial_);
      const double trial_cost = problem_.linearize(trial_);
      const double decrease = cost - trial_cost;
      fresh_ = decrease > 0.0;
      if (fresh_) {
        state_.swap(trial_);
        cost = trial_cost;
        report_.costs.push_back(cost);
      }
      if (last && !(decrease > little)) {
        if (settled()) return finish(SolverStatus::kConverged);
      } else if (fresh_) {
        adapt_radius(decrease / predicted);
        problem_.assemble();
      } else {
        radius_ = 0.25 * std::min(radius_, length(step_));
        if (radius_ < kSmallestRadius * scale_) {
          return finish(status_without_decrease(problem_, state_, cost));
        }
      }
    }
    return finish(SolverStatus::kIterationLimit);
  }

 private:
  /// Length of a step in standard deviations: the norm of the root of the diagonal of H times it.
  double length(const std::vector<double>& v) const {
    double sum = 0.0;
    for (std::size_t i = 0; i < v.size(); ++i) sum += system_.diagonal()[i] * v[i] * v[i];
    return std::sqrt(sum);
  }

  /// The minimum along the steepest descent, and the Gauss-Newton step.
  void compute_directions() {
    const std::vector<double>& g = system_.gradient();
    double slope = 0.0;
    for (std::size_t i = 0; i < g.size(); ++i) {
      descent_[i] = g[i] == 0.0 ? 0.0 : -g[i] / system_.diagonal()[i];
      slope -= descent_[i] * g[i];
      newton_[i] = -g[i];
    }
    system_.matrix().multiply(descent_.data(), product_.data());
    double curvature = 0.0;
    for (std::size_t i = 0; i < g.size(); ++i) curvature += descent_[i] * product_[i];
    if (curvature > 0.0) {
      for (double& x : descent_) x *= slope / curvature;
    }

    if (damping_ == 0.0) {
      Undamped undamped = factorize_undamped(problem_);
      report_.under_constrained = std::move(undamped.free);
      if (!undamped.usable) damping_ = kSingularDamping;
    }
    has_newton_ = damping_ == 0.0 || problem_.factorize(damping_) < 0;
    if (!has_newton_) {
      newton_ = descent_;
      return;
    }
    system_.solve(newton_.data());
  }

  /// Returns whether the step is the whole Gauss-Newton step.
  bool choose_step() {
    if (length(newton_) <= radius_) {
      step_ = newton_;
      return has_newton_;
    }
    const double descent_length = length(descent_);
    if (descent_length >= radius_) {
      for (std::size_t i = 0; i < step_.size(); ++i) {
        step_[i] = descent_[i] * radius_ / descent_length;
      }
      return false;
    }
    // The t at which |descent + t (newton - descent)| equals the radius.
    double a = 0.0;
    double b = 0.0;
    for (std::size_t i = 0; i < step_.size(); ++i) {
      const double d = newton_[i] - descent_[i];
      a += system_.diagonal()[i] * d * d;
      b += system_.diagonal()[i] * d * descent_[i];
    }
    const double c = radius_ * radius_ - descent_length * descent_length;
    const double t = c / (b + std::sqrt(b * b + a * c));
    for (std::size_t i = 0; i < step_.size(); ++i) {
      step_[i] = descent_[i] + t * (newton_[i] - descent_[i]);
    }
    return false;
  }

  double predicted_decrease() {
    system_.matrix().multiply(step_.data(), product_.data());
    double sum = 0.0;
    for (std::size_t i = 0; i < step_.size(); ++i) {
      sum -= step_[i] * (system_.gradient()[i] + 0.5 * product_[i]);
    }
    return sum;
  }

  void adapt_radius(double gain) {
    if (gain > 0.75) radius_ = std::max(radius_, 3.0 * length(step_));
    if (gain < 0.25) radius_ = 0.5 * std::min(radius_, length(step_));
  }

  bool settled() {
    if (is_settled(problem_, state_, report_)) return true;
    damping_ = 0.0;
    fresh_ = true;
    return false;
  }

  SolverReport finish(SolverStatus status) {
    finish_report(status, report_);
    return std::move(report_);
  }

  Problem& problem_;
  NormalEquations& system_;
  Problem::State& state_;
  const SolverOptions& options_;
  double scale_;
  double radius_;
  double damping_ = 0.0;
  bool has_newton_ = false;
  bool fresh_ = true;  // whether the directions must be computed
  std::vector<double> descent_, newton_, step_, product_;
  Problem::State trial_;
  SolverReport report_;
};

}  // namespace

SolverReport dogleg(Problem& problem, Problem::State& state, const SolverOptions& options) {
  const auto start = std::chrono::steady_clock::now();
  SolverReport report = Dogleg(problem, state, options).run();
  report.seconds = seconds_since(start);
  return report;
}

SolverResult dogleg(const HybridGraph& graph, const Estimate& initial,
                    const SolverOptions& options) {
  return solve_graph(graph, initial, options, [](auto&... args) { return dogleg(args...); });
}

}  // namespace hybrid
