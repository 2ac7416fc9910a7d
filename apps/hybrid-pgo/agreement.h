// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, the hybrid mapping authors

#pragma once

#include <vector>

#include "apps/hybrid-pgo/outputs.h"
#include "apps/hybrid-pgo/solution.h"
#include "mrpt_plugins/health/health.h"

namespace hybrid {

/// Whether closures that were measured at different times agree with the path. `noise` has the
/// scatter of the closures, where it was measured. Empty where there are no closures, or more
/// variables than those whose covariances take seconds.
Health graph_agreement(const Input& input, const Solution& solution, const std::vector<Loop>& loops,
                       const std::vector<NoiseRecord>& noise);

}  // namespace hybrid
