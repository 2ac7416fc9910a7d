// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, the hybrid mapping authors
#pragma once

#include <optional>
#include <vector>

#include "libhybrid/hybrid/graph.h"

namespace HYBRID_API hybrid {

/// The evidence of an assignment of the discrete variables, with the continuous ones integrated
/// out.
struct Evidence {
  /// log of the integral of exp(-L(C, D)) over C (eq. 6), -infinity for an impossible assignment;
  /// empty if the assignment leaves variables undetermined, since the integral diverges.
  std::optional<double> log;
  std::vector<Key> under_constrained;  ///< undetermined variables, the least determined first
};

/// The Laplace approximation of the evidence of the assignment of an estimate,
///   log p = -L(C, D) - log det(A) / 2 + n log(2 pi) / 2,
/// with A the Hessian of eq. 13, from its Cholesky factor, and n its size. Exact if the factors are
/// linear. C must minimise L for this D (eq. 8b). Normalisers are included, so that assignments
/// whose components differ in dimension, or are null, can be compared. Throws Error for missing
/// values.
Evidence log_evidence(const HybridGraph& graph, const Estimate& estimate, int threads = 0);

}  // namespace hybrid
