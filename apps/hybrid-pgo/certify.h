// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, the hybrid mapping authors

#pragma once

#include <vector>

#include "apps/hybrid-pgo/options.h"
#include "apps/hybrid-pgo/outputs.h"
#include "apps/hybrid-pgo/solution.h"
#include "libhybrid/solvers/certificate.h"

namespace hybrid {

/// Solves the graph as the options say; `loops` stays empty if it is to be filled by find_loops().
Solution solve_graph(const Input& input, const Options& options, std::vector<Loop>& loops);

/// Certifies a solution. In batch, where it is not verified and the Riemannian staircase finds
/// poses that cost less, the graph is solved again from these, and the new solution and its loops
/// are taken if their objective is lower. With closures in question, `discrete_gap` bounds how much
/// lower the joint objective can be.
Certificate certify_solution(const Input& input, const Options& options, std::vector<Loop>& loops,
                             Solution& solution);

}  // namespace hybrid
