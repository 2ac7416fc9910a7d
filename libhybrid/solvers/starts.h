// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, the hybrid mapping authors
#pragma once

#include <functional>
#include <string>
#include <vector>

#include "libhybrid/pose_graph/pose_graph.h"
#include "libhybrid/solvers/options.h"
#include "libhybrid/solvers/problem.h"

namespace HYBRID_API hybrid {

/// Somewhere to start from, made when it is wanted.
struct Start {
  std::string name;
  std::function<Values()> make;
};

/// What a start came to.
struct StartTrial {
  std::string name;
  double cost = 0.0;   ///< after `iterations`
  int iterations = 0;  ///< linear systems solved
};

struct StartsResult {
  Values values;
  SolverReport report;             ///< of the start that won; iterations and time are those of all
  std::vector<StartTrial> trials;  ///< those made, in their order
  std::size_t won = 0;             ///< among the trials
};

/// Whether noise explains the residuals at a state, so that no lower minimum is worth a search: the
/// squared whitened norm of all of them is below its chi-square quantile, with as many degrees of
/// freedom as there are more residuals than unknowns, and no factor has one that is beyond chance
/// among so many. Both at a false-alarm rate of 0.001. Where the noise is overstated a wrong
/// minimum may pass, too; where it is understated the right one may not.
bool is_explained_by_noise(const Problem& problem, const Problem::State& state);

/// Levenberg-Marquardt on a graph without discrete variables, from the first start; unless noise
/// explains what that comes to in a few iterations, the other starts get as many, and the one of
/// least cost goes on, and any other that is below what that ends with. Throws Error for no start,
/// and as levenberg_marquardt does.
StartsResult solve_from_starts(const HybridGraph& graph, const std::vector<Start>& starts,
                               const SolverOptions& options = {});

/// The cheap starts of a pose graph: `initial` under its name, then those of "odometry", "chordal"
/// and "tree" that it is not. `factors` are those of to_factors at `initial`. All arguments must
/// outlive the starts.
std::vector<Start> pose_graph_starts(const PoseGraph& graph,
                                     const std::vector<ContinuousFactorPtr>& factors,
                                     const std::string& name, const Values& initial);

}  // namespace hybrid
