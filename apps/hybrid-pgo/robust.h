// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, the hybrid mapping authors

#pragma once

#include "apps/hybrid-pgo/options.h"
#include "apps/hybrid-pgo/outputs.h"
#include "apps/hybrid-pgo/solution.h"
#include "libhybrid/selection/part_links.h"

namespace hybrid {

/// Solves with closures that may be false, by the method of the options, and fills `loops` with all
/// closures in the order of the file. Parts that the trusted measurements leave apart are joined by
/// closures that agree, see join_parts. Throws Error for a file of trusted pairs that
/// cannot be read.
Solution solve_robust(const Input& input, const Options& options, std::vector<Loop>& loops);

/// What the decisions on the links of parts say about the result.
Health links_health(const JoinedParts& joined, const std::vector<ClosureDecision>& links);

/// How much lower than that of a solution the joint objective of other poses and decisions can be
/// at most, see bound_objective.
double discrete_gap(const Input& input, const Options& options, const std::vector<Loop>& loops,
                    const Values& values, int budget);

/// Sets precision and recall of the accepted closures by a file with rows `i j` (a true closure) or
/// `i j 0|1`. Closures that are not in the file are false, or unknown if the file has a 0. Throws
/// Error naming file and line.
void compare_with_labels(const std::string& file, const std::vector<Loop>& loops,
                         TruthSummary& truth);

}  // namespace hybrid
