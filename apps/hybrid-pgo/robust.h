// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, the hybrid mapping authors

#pragma once

#include "apps/hybrid-pgo/options.h"
#include "apps/hybrid-pgo/outputs.h"
#include "apps/hybrid-pgo/solution.h"

namespace hybrid {

/// Solves with closures that may be false, by the method of the options, and fills in `loops`: all
/// closures in the order of the file. Closures without which the trusted measurements fall into
/// parts are trusted too, with a note in the solution. Throws Error for a file of trusted pairs
/// that cannot be read.
Solution solve_robust(const Input& input, const Options& options, std::vector<Loop>& loops);

/// Share of the accepted closures that are true, and of the true ones that are accepted, by a file
/// of rows `i j` (the true ones) or `i j 0|1`, where pairs not named are false, or unknown. Throws
/// Error naming file and line.
void compare_with_labels(const std::string& file, const std::vector<Loop>& loops,
                         TruthSummary& truth);

}  // namespace hybrid
