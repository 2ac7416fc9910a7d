// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, the hybrid mapping authors
#pragma once

#include "libhybrid/closures/mixture_graph.h"
#include "libhybrid/closures/problem.h"
#include "libhybrid/solvers/alternating.h"

namespace HYBRID_API hybrid {

struct AlternationOptions {
  MixtureOptions mixture;
  AlternatingOptions alternating;
};

/// The solver of the paper on eq. 16: alternating minimisation from the initial values, at which
/// every closure is classified first. It ends in the first local minimum.
RobustResult solve_alternating(const RobustProblem& problem,
                               const AlternationOptions& options = {});

}  // namespace hybrid
