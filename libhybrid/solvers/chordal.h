// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, the hybrid mapping authors
#pragma once

#include <vector>

#include "libhybrid/core/values.h"
#include "libhybrid/factors/factor.h"

namespace HYBRID_API hybrid {

/// Initial values by chordal relaxation (Martinec and Pajdla 2007), which needs no initial guess:
/// rotations by linear least squares over matrices from the relative poses among the factors,
/// projected onto rotations; then translations by linear least squares. Where landmarks are seen
/// with range and bearing, their positions take part in both, and in the first the translations
/// too. Variables with a prior keep their `initial` values, or the first pose if no pose has one;
/// so do variables that no chain of these measurements connects to them.
Values chordal_initialization(const std::vector<ContinuousFactorPtr>& factors,
                              const Values& initial);

}  // namespace hybrid
