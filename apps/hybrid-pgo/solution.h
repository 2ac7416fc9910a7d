// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, the hybrid mapping authors

#pragma once

#include <cstdint>
#include <map>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "libhybrid/closures/problem.h"
#include "libhybrid/hybrid/graph.h"
#include "libhybrid/online/online_selection.h"
#include "libhybrid/pose_graph/pose_graph.h"
#include "libhybrid/solvers/starts.h"
#include "mrpt_plugins/health/health.h"
#include "mrpt_plugins/mapping/map_result.h"
#include "mrpt_plugins/output/summary.h"

namespace hybrid {

/// A pose graph with initial values of all variables.
struct Input {
  PoseGraph graph;
  Values initial;
  std::string start;                         ///< kind of initial values, as in Options
  std::vector<ContinuousFactorPtr> factors;  ///< those of `to_factors`
  std::vector<bool> is_closure;              ///< of each relative pose; those of breaks are
  std::vector<std::string> breaks;           ///< their ids, see bound_breaks
  std::vector<int> first_hypotheses;  ///< index of the first hypothesis of the file, by edge with
                                      ///< several

  bool is_3d() const { return !graph.poses3.empty() || !graph.points3.empty(); }
  /// Poses in the order of their ids.
  std::vector<Key> poses() const;
};

/// Whether a factor of `to_factors` is a pose or a position measured in the frame of the map.
inline bool is_in_map(const PoseGraph& graph, std::size_t factor) {
  return factor >= graph.edge_count() && factor < graph.edge_count() + graph.prior_count();
}

/// Reads a graph. `start` is "file", "odometry", "chordal", "tree" or "auto": the file if it has
/// all vertices, else odometry. With a seed `shuffle`, hypotheses are put into random order.
/// `repair_information` makes information matrices positive definite. Where closures are
/// `in_question`, edges that came twice count once, and odometry that says nothing is a closure.
/// Throws Error naming the file if it is malformed, not connected, or lacks vertices.
Input read_input(const std::string& path, const std::string& start,
                 std::optional<std::uint64_t> shuffle = std::nullopt,
                 bool repair_information = false, bool in_question = false);

/// Variables whose covariances take seconds: checks that need them judge no larger graph.
inline constexpr std::size_t kMostWithCovariances = 100000;

/// The result of a solver.
struct Solution {
  Values values;
  std::string method;
  std::string message;  ///< empty if it converged
  int signal = 0;       ///< signal that stopped it between two poses, or 0
  Health health;        ///< what only the solver knows
  int iterations = 0;
  double seconds = 0;
  double objective = 0;
  double cost = 0;
  std::vector<double> objectives;         ///< batch: at the start and after each accepted step
  std::vector<StepRecord> steps;          ///< online
  std::optional<double> variance_factor;  ///< of the noise, if the method estimates it
  std::vector<MemberSummary> members;     ///< of a portfolio
  std::optional<double> cost_online;      ///< after the last step, before solving to convergence
  /// On closures that were not trusted, by number of the relative pose in the graph.
  std::map<std::size_t, ClosureDecision> decisions;
  std::vector<int> hypotheses;     ///< chosen index, for each edge with several
  std::vector<StartTrial> starts;  ///< starts tried; empty without a choice
  std::string start;               ///< the best start
};

/// Levenberg-Marquardt on the whole graph, from the initial values of the input, or with `compare`
/// from the best of all cheap starts. Throws Error if there is no estimate.
Solution solve_batch(const Input& input, bool compare, const SolverOptions& options);

/// The incremental smoother, pose by pose, then to convergence. Stops when the program is
/// interrupted. Throws Error if there is no estimate, Interrupted before the first pose.
Solution solve_online(const Input& input);

/// The same with decisions about hypotheses and closures (`trusted` as in Options). Throws Error
/// for a file that cannot be read or lists a closure that is not in the graph.
Solution solve_selection(const Input& input, const std::string& trusted,
                         const OnlineSelectionOptions& options, bool keep_history);

}  // namespace hybrid
