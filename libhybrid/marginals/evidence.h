// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, the hybrid mapping authors
#pragma once

#include <Eigen/Core>
#include <optional>
#include <vector>

#include "libhybrid/hybrid/graph.h"

namespace HYBRID_API hybrid {

/// What the data say of an assignment of the discrete variables, whatever the continuous ones are.
struct Evidence {
  /// log of the integral of exp(-L(C, D)) over C (eq. 6), -infinity for an impossible assignment;
  /// nothing where the assignment leaves variables undetermined: the integral has no value then.
  std::optional<double> log;
  std::vector<Key> under_constrained;  ///< variables left undetermined, most first
};

/// The Laplace approximation of the evidence of the assignment of an estimate,
///   log p = -L(C, D) - log det(A) / 2 + n log(2 pi) / 2,
/// with A the Hessian of eq. 13, from its Cholesky factor, and n its size. Exact where the factors
/// are linear. C must minimise L for this D (eq. 8b). Normalisers count, so that assignments that
/// choose components of other dimensions, or none, compare. Throws Error for missing values.
Evidence log_evidence(const HybridGraph& graph, const Estimate& estimate, int threads = 0);

/// What it adds to the log evidence to put the factor `to` in the place of `from`, with their
/// normalisers; null for none. Both are linearised at `values`, which minimise L with `from`;
/// `covariance` is the joint one of `keys`, all variables of the two, with `from` in force. Nothing
/// where variables are undetermined without `from`. Throws Error where a variable is not among
/// `keys`, or the covariance is not of their size.
std::optional<double> log_evidence_change(const std::vector<Key>& keys,
                                          const Eigen::MatrixXd& covariance, const Values& values,
                                          const ContinuousFactor* from, const ContinuousFactor* to);

}  // namespace hybrid
