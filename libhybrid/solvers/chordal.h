// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, the hybrid mapping authors
#pragma once

#include <vector>

#include "libhybrid/core/values.h"
#include "libhybrid/factors/factor.h"

namespace HYBRID_API hybrid {

/// A start that needs none: rotations from the relative poses among the factors by linear least
/// squares over matrices, brought back to rotations; then translations, linear too. Poses with a
/// prior stay at their `initial` values, or else the first one; so do variables that no relative
/// pose connects to such a pose.
Values chordal_initialization(const std::vector<ContinuousFactorPtr>& factors,
                              const Values& initial);

}  // namespace hybrid
