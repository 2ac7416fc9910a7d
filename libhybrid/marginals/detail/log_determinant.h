// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, the hybrid mapping authors
#pragma once

#include <vector>

#include "libhybrid/solvers/problem.h"

namespace hybrid {

/// log det of the Hessian of a problem at its last linearisation.
struct LogDeterminant {
  double value = 0.0;
  std::vector<Key> under_constrained;  ///< where the Hessian is singular: the value means nothing
};

/// Assembles and factorises.
LogDeterminant log_determinant(Problem& problem);

}  // namespace hybrid
