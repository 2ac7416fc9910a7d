// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, the hybrid mapping authors
#pragma once

#include <string>
#include <vector>

#include "libhybrid/closures/alternatives.h"
#include "libhybrid/closures/closure_decision.h"
#include "libhybrid/core/values.h"
#include "libhybrid/factors/factor.h"

namespace HYBRID_API hybrid {

/// A pose graph whose loop closures may be false (section V-A): factors that are trusted as they
/// are, and candidates, each of which a binary variable switches between inlier and outlier
/// (eq. 16).
struct RobustProblem {
  std::vector<ContinuousFactorPtr> trusted;   ///< odometry and priors
  std::vector<ContinuousFactorPtr> closures;  ///< candidates, with their inlier covariance
  Values initial;                             ///< of all variables
  /// Closures of which at most one is true. Loop closure selection admits one only where it stands
  /// out from the others; other methods do not heed them.
  Alternatives alternatives = {};
};

/// The result of one member of a portfolio of solvers.
struct MemberSummary {
  std::string method;
  double objective = 0.0;  ///< see RobustResult
  /// The same after rejecting those closures of the member that the evidence contradicts, or does
  /// not support. Members are compared by this, since the objective alone would reward false
  /// closures that agree with each other.
  double verified_objective = 0.0;
  std::size_t accepted = 0;
  double seconds = 0.0;
};

/// The result of a robust solver. `decisions` is in the order of `RobustProblem::closures`.
struct RobustResult {
  std::string method;
  Values values;
  std::vector<ClosureDecision> decisions;
  double objective = 0.0;  ///< joint negative log posterior of eq. 6 under the mixture of eq. 17
  double cost = 0.0;       ///< half the weighted squared error of trusted and accepted factors
  int iterations = 0;      ///< linear systems solved
  double seconds = 0.0;
  bool converged = true;
  std::string message;
  /// The objective that the method lowers, at the start and after each macro-step.
  std::vector<double> objectives;
  /// Whether inlier probabilities have the poses integrated out (see integrate_poses); else they
  /// are conditional on the continuous estimate (eq. 14).
  bool poses_integrated = false;
  /// Estimate of the factor by which the variances of the noise are understated.
  double variance_factor = 1.0;
  std::vector<MemberSummary> members;  ///< of a portfolio
};

}  // namespace hybrid
