// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, the hybrid mapping authors

#pragma once

#include <cstdint>
#include <map>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "libhybrid/hybrid/graph.h"
#include "libhybrid/pose_graph/pose_graph.h"
#include "libhybrid/selection/online_closure_selection.h"
#include "libhybrid/solvers/starts.h"
#include "mrpt_plugins/mapping/map_result.h"
#include "mrpt_plugins/output/summary.h"

namespace hybrid {

/// A pose graph with a start for all its vertices.
struct Input {
  PoseGraph graph;
  Values initial;
  std::string start;                         ///< what `initial` is, as in Options
  std::vector<ContinuousFactorPtr> factors;  ///< those of `to_factors`
  std::vector<int> first_hypotheses;  ///< where the first of the file is, by edge that has several

  bool is_3d() const { return !graph.poses3.empty() || !graph.points3.empty(); }
  /// Poses in the order of their ids.
  std::vector<Key> poses() const;
};

/// Reads a graph; `start` is "file", "odometry", "chordal", "tree" or "auto": the file if it has
/// all vertices, else odometry; hypotheses are put in a random order where a seed for it is given,
/// and information that is not positive definite is repaired where asked.
/// Throws Error naming the file where it is malformed, not connected, or lacks vertices it needs.
Input read_input(const std::string& path, const std::string& start,
                 std::optional<std::uint64_t> shuffle = std::nullopt,
                 bool repair_information = false);

/// What became of a loop closure that was not trusted.
struct Decision {
  std::string text;  ///< "accepted", "undecided" or "rejected"
  double inlier_probability = 0;
  /// Online: the poses at which it was taken for something else than before, and for what.
  std::vector<std::pair<std::uint64_t, std::string>> history = {};
};

/// What a solver made of it.
struct Solution {
  Values values;
  std::string method;
  std::string message;  ///< empty if it converged
  int signal = 0;       ///< that stopped it between two poses
  std::string note;     ///< what the user should know of a good result
  int iterations = 0;
  double seconds = 0;
  double objective = 0;
  double cost = 0;
  std::vector<double> objectives;         ///< in batch, at the start and after each step down
  std::vector<StepRecord> steps;          ///< online
  std::optional<double> variance_factor;  ///< of the noise, where the method estimates it
  std::vector<MemberSummary> members;     ///< of a portfolio
  std::optional<double> cost_online;      ///< after the last step, before solving to convergence
  std::map<std::size_t, Decision> decisions;  ///< by number of the relative pose in the graph
  std::vector<int> hypotheses;                ///< chosen, for each edge that has several
  std::vector<StartTrial> starts;             ///< that were tried; empty where there was no choice
  std::string start;                          ///< the one that won
  std::vector<Key> order;  ///< elimination order; empty where the solver does not tell
};

/// Levenberg-Marquardt on the whole graph, from the start of the input, or with `compare` from the
/// best of all cheap ones. Throws Error where there is no estimate.
Solution solve_batch(const Input& input, bool compare);

/// The incremental smoother, pose by pose, then to convergence; it stops where the program is asked
/// to. Throws Error where there is no estimate, Interrupted before the first pose.
Solution solve_online(const Input& input);

/// The same with hypotheses, and with selection of closures (`trusted` as in Options). Throws Error
/// for a file that cannot be read or names a closure that the graph does not have.
Solution solve_hypotheses(const Input& input);
Solution solve_selection(const Input& input, const std::string& trusted,
                         const OnlineClosureSelectionOptions& options, bool keep_history);

}  // namespace hybrid
