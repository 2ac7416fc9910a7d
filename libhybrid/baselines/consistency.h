// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, the hybrid mapping authors
#pragma once

#include <functional>
#include <vector>

#include "libhybrid/closures/mixture_graph.h"
#include "libhybrid/closures/problem.h"

namespace HYBRID_API hybrid {

struct ConsistencyOptions {
  /// Two closures agree if the squared whitened error of their loop is below the chi-square
  /// quantile of this probability.
  double probability = 0.99;
  long max_nodes = 10000;  ///< of the exact search for the largest set; 0: greedy only
  /// Throws Error for more closures: time and memory grow with the square of their number.
  int max_closures = 10000;
};

/// The result of pairwise consistency maximisation.
struct Consistency {
  /// By closure: whether it is in the largest set in which all agree with each other, or cannot be
  /// compared because it or the odometry between its ends is no relative pose.
  std::vector<bool> kept;
  std::size_t compared = 0;  ///< closures compared
  std::size_t pairs = 0;     ///< that agree
  bool exact = true;         ///< whether the set is proven to be the largest
  double seconds = 0.0;
};

/// Pairwise consistency maximisation (Mangelson et al., 2018, eq. 8 and 12): closures (a, b) and
/// (c, d) agree if the loop a, b, d, c over them and odometry closes within the covariance of all
/// motions along it. Odometry consists of the trusted relative poses from each pose to the next;
/// errors of two paths along the same part of it count as independent. The exact search stops at
/// its limit, with the largest set found. Throws Error for a probability outside (0, 1).
Consistency pairwise_consistency(const RobustProblem& problem,
                                 const ConsistencyOptions& options = {});

/// Runs `solver` on the closures that are kept; the others are rejected.
using RobustSolver = std::function<RobustResult(const RobustProblem&)>;
RobustResult solve_consistent(const RobustProblem& problem, const ConsistencyOptions& options,
                              const MixtureOptions& mixture, const RobustSolver& solver);

}  // namespace hybrid
