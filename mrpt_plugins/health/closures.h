// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, the hybrid mapping authors

#pragma once

#include <cstddef>
#include <vector>

#include "libhybrid/closures/closure_decision.h"
#include "mrpt_plugins/health/health.h"

namespace HYBRID_API hybrid {

/// What the closures of a graph say about the result, by the decisions on those that are not
/// trusted: how many were rejected, and how narrowly the narrowest decision was made.
Health closure_health(const std::vector<ClosureDecision>& decisions);

/// Whether closures agree on how the parts of a trajectory are joined, by the decisions on the
/// links of join_parts; `candidates` closures are between parts, links included. Empty for one
/// part.
Health parts_health(const std::vector<ClosureDecision>& links, std::size_t candidates);

}  // namespace hybrid
