// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, the hybrid mapping authors
#pragma once

#include <vector>

#include "libhybrid/solvers/problem.h"

namespace HYBRID_API hybrid {

/// log det of the Hessian of a problem at its last linearisation.
struct LogDeterminant {
  double value = 0.0;                  ///< meaningless if the Hessian is singular
  std::vector<Key> under_constrained;  ///< empty unless the Hessian is singular
};

/// Assembles and factorises the problem.
LogDeterminant log_determinant(Problem& problem);

}  // namespace hybrid
