// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, the hybrid mapping authors

#pragma once

#include "apps/hybrid-pgo/options.h"

namespace hybrid {

/// Reads the graph, solves it, writes the results and prints a summary. Returns the exit code.
/// Throws on failure.
int optimize(const Options& options);

}  // namespace hybrid
