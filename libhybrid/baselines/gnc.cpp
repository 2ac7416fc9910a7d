// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, the hybrid mapping authors
#include "libhybrid/baselines/gnc.h"

#include <algorithm>
#include <cmath>

#include "libhybrid/core/chi_square.h"
#include "libhybrid/core/elapsed.h"

namespace hybrid {
namespace {

constexpr int kSettlingRounds = 20;
constexpr double kLargeMu = 1e12;

/// The kernel rho(s) = weight s, for a weight that its owner may change.
Kernel weighted_by(const double* weight) {
  return {[weight](double s) { return *weight * s; }, [weight](double) { return *weight; }};
}

class Gnc {
 public:
  Gnc(const RobustProblem& problem, const GncOptions& options)
      : problem_(problem),
        options_(options),
        weights_(problem.closures.size(), 1.0),
        weighted_(problem, under_weights(), {}, problem.initial, roles(), options.solver.threads) {
    for (const ContinuousFactorPtr& closure : problem.closures) {
      c2_.push_back(chi_square_quantile(options.inlier_probability, closure->rows()));
    }
  }

  RobustResult run() {
    RobustResult result;
    result.method = options_.loss == GncLoss::kTruncatedLeastSquares ? "gnc" : "gnc-gm";
    SolverOptions few = options_.solver;
    few.max_iterations = options_.iterations_per_round;
    weighted_.solve(few);
    double mu = first_mu();
    result.converged = mu < 0.0;  // least squares explains all closures
    for (int round = 0; round < options_.max_rounds && !result.converged; ++round) {
      const bool last = options_.loss == GncLoss::kGemanMcClure && mu == 1.0;
      update_weights(mu);
      if (options_.restart) weighted_.set_values(problem_.initial);
      weighted_.solve(few);
      result.converged = last || (options_.loss == GncLoss::kTruncatedLeastSquares && binary());
      mu = gnc_next_mu(options_.loss, mu, options_.growth);
    }
    const bool settled = result.converged;
    weighted_.report(settle(), result);
    if (!settled) {
      result.converged = false;
      result.message = "weights were still changing after " + std::to_string(options_.max_rounds) +
                       " rounds, the limit";
    }
    result.values = weighted_.values();
    result.iterations = weighted_.iterations();
    std::vector<bool> accepted;
    for (double w : weights_) accepted.push_back(w >= 0.5);
    finish(problem_, accepted, options_.mixture, result);
    return result;
  }

 private:
  /// The limit of large mu, truncated least squares itself: closures within c^2 have weight one and
  /// all others zero, until the weights no longer change. The cost falls at every round.
  SolverReport settle() {
    SolverReport report = weighted_.solve(options_.solver);
    if (options_.loss == GncLoss::kGemanMcClure) return report;
    for (int round = 0; round < kSettlingRounds; ++round) {
      const std::vector<double> before = weights_;
      update_weights(kLargeMu);
      if (weights_ == before) break;
      report = weighted_.solve(options_.solver);
    }
    return report;
  }

  std::vector<ContinuousFactorPtr> under_weights() {
    std::vector<ContinuousFactorPtr> factors;
    for (std::size_t k = 0; k < weights_.size(); ++k) {
      factors.push_back(
          std::make_shared<KernelFactor>(problem_.closures[k], weighted_by(&weights_[k])));
    }
    return factors;
  }

  std::vector<ClosureRole> roles() const {
    std::vector<ClosureRole> roles;
    for (double w : weights_) {
      roles.push_back(w == 0.0                         ? ClosureRole::kAbsent
                      : w < options_.negligible_weight ? ClosureRole::kWeak
                                                       : ClosureRole::kCoupled);
    }
    return roles;
  }

  /// The first mu for the closure of largest residual relative to its c^2; negative if all are
  /// within it.
  double first_mu() const {
    const std::vector<double> s = chi_squares(problem_, weighted_.values());
    double first = -1.0;
    for (std::size_t k = 0; k < s.size(); ++k) {
      const double mu = gnc_first_mu(options_.loss, s[k], c2_[k]);
      if (mu < 0.0) continue;
      const bool truncated = options_.loss == GncLoss::kTruncatedLeastSquares;
      first = first < 0.0 ? mu : truncated ? std::min(first, mu) : std::max(first, mu);
    }
    return first;
  }

  void update_weights(double mu) {
    const std::vector<double> s = chi_squares(problem_, weighted_.values());
    for (std::size_t k = 0; k < s.size(); ++k) {
      weights_[k] = gnc_weight(options_.loss, s[k], mu, c2_[k]);
    }
    weighted_.set_roles(roles());
  }

  bool binary() const {
    return std::all_of(weights_.begin(), weights_.end(), [&](double w) {
      return w <= options_.binary || w >= 1.0 - options_.binary;
    });
  }

  const RobustProblem& problem_;
  const GncOptions& options_;
  std::vector<double> weights_;
  std::vector<double> c2_;
  ClosureProblem weighted_;
};

}  // namespace

double gnc_first_mu(GncLoss loss, double largest_chi_square, double c2) {
  if (loss == GncLoss::kGemanMcClure) return std::max(1.0, 2.0 * largest_chi_square / c2);
  return largest_chi_square <= c2 ? -1.0 : c2 / (2.0 * largest_chi_square - c2);
}

double gnc_weight(GncLoss loss, double chi_square, double mu, double c2) {
  if (loss == GncLoss::kGemanMcClure) {
    const double ratio = mu * c2 / (chi_square + mu * c2);
    return ratio * ratio;
  }
  if (chi_square >= (mu + 1.0) / mu * c2) return 0.0;
  if (chi_square <= mu / (mu + 1.0) * c2) return 1.0;
  return std::sqrt(c2 / chi_square * mu * (mu + 1.0)) - mu;
}

double gnc_next_mu(GncLoss loss, double mu, double growth) {
  return loss == GncLoss::kGemanMcClure ? std::max(1.0, mu / growth) : mu * growth;
}

RobustResult solve_gnc(const RobustProblem& problem, const GncOptions& options) {
  const auto start = std::chrono::steady_clock::now();
  if (!(options.inlier_probability > 0.0) || !(options.inlier_probability < 1.0)) {
    throw Error("the inlier probability of GNC must be in (0, 1), got " +
                std::to_string(options.inlier_probability));
  }
  if (!(options.growth > 1.0)) {
    throw Error("the growth of mu of GNC must be above 1, got " + std::to_string(options.growth));
  }
  RobustResult result = Gnc(problem, options).run();
  result.seconds = seconds_since(start);
  return result;
}

}  // namespace hybrid
