// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, the hybrid mapping authors

#pragma once

#include <vector>

#include "apps/hybrid-pgo/outputs.h"
#include "apps/hybrid-pgo/solution.h"
#include "mrpt_plugins/health/health.h"
#include "mrpt_plugins/input/log_correction.h"

namespace hybrid {

/// By which factor the sigmas of the graph are too small, of odometry, of the closures in force and
/// of all else, as the residuals at the solution say: the squared residuals, divided by how far the
/// other measurements check each. Of at most 200 factors of a kind, evenly over the graph.
std::vector<NoiseRecord> graph_noise(const Input& input, const Solution& solution,
                                     const std::vector<Loop>& loops);

/// An entry where the information of the graph seems to be covariances.
Health information_health(const PoseGraph& graph);

/// An entry for each kind that was measured.
Health noise_health(const std::vector<NoiseRecord>& noise);

}  // namespace hybrid
