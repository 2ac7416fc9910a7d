// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, the hybrid mapping authors
#pragma once

#include "libhybrid/closures/closure_problem.h"

namespace HYBRID_API hybrid {

enum class GncLoss { kTruncatedLeastSquares, kGemanMcClure };

/// Graduated non-convexity (Yang et al., 2020).
struct GncOptions : ComparisonOptions {
  GncLoss loss = GncLoss::kTruncatedLeastSquares;
  /// Squared whitened norms of true closures stay below the chi-square quantile of this
  /// probability: the c^2 of the paper.
  double inlier_probability = 0.99;
  double growth = 1.4;            ///< of the control parameter mu, per round
  int max_rounds = 200;           ///< of weights and mu
  int iterations_per_round = 10;  ///< of the weighted least-squares problem
  /// Whether every round starts at the initial values, since a map folded by false closures does
  /// not unfold; else it starts at the result of the last round, which is faster.
  bool restart = true;
  /// Truncated least squares: a weight this near to 0 or 1 is binary.
  double binary = 1e-3;
};

/// mu of the first round for the largest squared whitened norm: c^2 / (2 s - c^2) for truncated
/// least squares, negative if s does not exceed c^2; 2 s / c^2, at least 1, for Geman-McClure
/// (remark 5).
double gnc_first_mu(GncLoss loss, double largest_chi_square, double c2);

/// The weight of a closure of squared whitened norm s: eq. 14 for truncated least squares, eq. 12
/// for Geman-McClure.
double gnc_weight(GncLoss loss, double chi_square, double mu, double c2);

/// mu of the next round: grows without bound for truncated least squares, falls to 1 for
/// Geman-McClure.
double gnc_next_mu(GncLoss loss, double mu, double growth);

/// Weighted least squares over all closures, weights from the residuals, then a less convex
/// surrogate, until weights are binary (truncated least squares) or mu is one (Geman-McClure).
/// Truncated least squares ends with rounds of weights 1 up to c^2 and 0 beyond. Closures of weight
/// zero are absent from the linear systems. Those with a final weight of at least one half are
/// accepted. Throws Error for a probability outside (0, 1) or a growth not above one.
RobustResult solve_gnc(const RobustProblem& problem, const GncOptions& options = {});

}  // namespace hybrid
