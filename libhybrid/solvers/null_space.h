// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, the hybrid mapping authors
#pragma once

#include <string>
#include <vector>

#include "libhybrid/solvers/problem.h"

namespace hybrid {

/// A pivot below this share of its diagonal entry is rounding error: the system is singular.
inline constexpr double kSingularPivotRatio = 1e-14;

/// Variables that can move without changing any linearised residual, those that move most first:
/// the support of a vector of the null space of H at the last linearisation, found by inverse
/// iteration. Replaces the factorisation. Call it when a factorisation without damping failed.
std::vector<Key> under_constrained_variables(Problem& problem);

/// Factorises H without damping. Returns nothing, or the variables that make it singular: those of
/// a null vector, or where none is found the one whose pivot failed.
std::vector<Key> factorize_undamped(Problem& problem);

/// "the factors leave x3, x4, ... (7 variables) undetermined ..." for reports.
std::string under_constrained_message(const std::vector<Key>& keys);

}  // namespace hybrid
