// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, the hybrid mapping authors
#pragma once

#include <functional>
#include <optional>
#include <string>
#include <vector>

#include "libhybrid/pose_graph/pose_graph.h"
#include "libhybrid/solvers/alternating.h"
#include "libhybrid/solvers/options.h"
#include "libhybrid/solvers/problem.h"

namespace HYBRID_API hybrid {

/// Initial values, computed when they are needed.
struct Start {
  std::string name;
  std::function<Values()> make;
};

/// The result of a solve from one start.
struct StartTrial {
  std::string name;
  double cost = 0.0;   ///< after `iterations`
  int iterations = 0;  ///< linear systems solved
};

struct StartsResult {
  Values values;
  SolverReport report;             ///< of the best start; iterations and time are those of all
  std::vector<StartTrial> trials;  ///< of the starts that were tried, in their order
  std::size_t won = 0;             ///< index of the best trial
  bool met_operations = false;     ///< the limit of operations came before that of iterations
};

/// Whether noise explains the residuals at a state, so that no lower minimum is worth a search: the
/// squared whitened norm of all of them is below its chi-square quantile, with degrees of freedom
/// residuals minus unknowns, and that of every factor is below its own quantile, which allows for
/// their number. Both tests have a false-alarm rate of 0.001. If the noise is overstated a wrong
/// minimum may pass, too; if it is understated the right one may not.
bool is_explained_by_noise(const Problem& problem, const Problem::State& state);

/// Levenberg-Marquardt on a graph without discrete variables from several starts. The first one
/// gets a few iterations; unless noise explains its residuals then, the others get as many. The one
/// of least cost then continues to its end, and after it any other whose cost is still lower.
/// Throws Error if there is no start, and as levenberg_marquardt does.
StartsResult solve_from_starts(const HybridGraph& graph, const std::vector<Start>& starts,
                               const SolverOptions& options = {});

/// The cheap starts of a pose graph: `initial`, called `name`, then those of "odometry", "chordal"
/// and "tree" with another name. `factors` are those of to_factors at `initial`. All arguments must
/// outlive the starts.
std::vector<Start> pose_graph_starts(const PoseGraph& graph,
                                     const std::vector<ContinuousFactorPtr>& factors,
                                     const std::string& name, const Values& initial);

/// One of these alone: "odometry", "chordal" or "tree". Where the graph measures the map, the
/// values are in the map. Throws Error for another name.
Values pose_graph_start(const PoseGraph& graph, const std::string& name);

/// What a chordal start of a solved graph leads to.
struct ChordalTrial {
  bool tried = false;              ///< not where noise explains the residuals, nor without poses
  double objective = 0.0;          ///< after a few iterations, or at the end if that is better
  std::optional<Estimate> better;  ///< the estimate then
};

/// Tries a chordal start, by the factors in force under the assignment of a `solved` estimate. If
/// it leads below the objective of that within a few iterations, by more than convergence leaves
/// open, it is solved to the end.
ChordalTrial try_chordal_start(const HybridGraph& graph, const Estimate& solved,
                               const AlternatingOptions& options = {});

}  // namespace hybrid
