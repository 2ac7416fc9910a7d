// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, the hybrid mapping authors
#pragma once

#include <string>
#include <vector>

#include "libhybrid/linear/extended_cholesky.h"
#include "libhybrid/solvers/problem.h"

namespace HYBRID_API hybrid {

/// A pivot below this share of the scale of its block may be rounding error: then extended
/// precision decides. Pivots of singular systems are 1e-18 to 3e-15 in graphs of up to some
/// thousand poses, and 2e-12 in a bundle of cameras close together, whose points are eliminated
/// with little information on their depth; pivots of regular systems are rarely below 1e-8.
inline constexpr double kSuspiciousPivot = 1e-10;

/// A variable that the factors do not determine.
struct FreeVariable {
  Key key;
  Eigen::MatrixXd directions;  ///< orthonormal basis (dim x k) of its undetermined tangents
};

/// The variables that the factors do not determine at an estimate: those that can move without
/// changing any linearised residual, alone or together, those that move most first. See
/// ExtendedCholesky for the criterion in floating point; the answer is the same in any frame. Costs
/// many times a factorisation in double precision. Throws Error for missing values, and if a
/// Jacobian is not finite.
std::vector<FreeVariable> free_variables(const HybridGraph& graph, const Estimate& estimate,
                                         WeakComponents weak = WeakComponents::kUncoupled);

/// The same from the factorisation of a problem at its last linearisation.
std::vector<FreeVariable> free_variables(const Problem& problem, const ExtendedCholesky& factor);

/// Factorises H without damping; false if a pivot failed or may be rounding error, so that the
/// factor is not reliable.
bool is_clearly_regular(Problem& problem);

/// The result of a factorisation of H without damping.
struct Undamped {
  bool usable = true;     ///< false if steps need damping
  std::vector<Key> free;  ///< variables that are not determined, those that move most first
};

/// Factorises H without damping at the last linearisation, which must be finite and that of the
/// last assembly. A pivot near rounding error is checked in extended precision.
Undamped factorize_undamped(Problem& problem);

/// "the factors leave x3, x4, ... (7 variables) undetermined ..." for reports.
std::string under_constrained_message(const std::vector<Key>& keys);

}  // namespace hybrid
