// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, the hybrid mapping authors
#include "libhybrid/marginals/log_determinant.h"

#include "libhybrid/solvers/null_space.h"

namespace hybrid {

LogDeterminant log_determinant(Problem& problem) {
  problem.assemble();
  LogDeterminant result;
  if (is_clearly_regular(problem)) {
    result.value = problem.system().log_determinant();
    return result;
  }
  const ExtendedCholesky factor = problem.extended_factor();
  result.value = factor.log_determinant();
  for (const FreeVariable& variable : free_variables(problem, factor)) {
    result.under_constrained.push_back(variable.key);
  }
  return result;
}

}  // namespace hybrid
