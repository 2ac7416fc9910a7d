// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, the hybrid mapping authors

#pragma once

#include <vector>

#include "libhybrid/closures/closure_decision.h"
#include "mrpt_plugins/health/health.h"

namespace HYBRID_API hybrid {

/// What the closures of a graph say about the result, by the decisions on those that are not
/// trusted: how many were rejected, and how narrowly the narrowest decision was made.
Health closure_health(const std::vector<ClosureDecision>& decisions);

}  // namespace hybrid
