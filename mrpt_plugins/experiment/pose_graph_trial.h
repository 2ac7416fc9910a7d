// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, the hybrid mapping authors

#pragma once

#include <map>
#include <optional>
#include <set>
#include <string>
#include <utility>
#include <vector>

#include "libhybrid/pose_graph/pose_graph.h"
#include "mrpt_plugins/evaluation/graph_truth.h"
#include "mrpt_plugins/evaluation/reliability.h"
#include "mrpt_plugins/experiment/ledger.h"
#include "mrpt_plugins/experiment/plan.h"

namespace HYBRID_API hybrid {

/// Names of the metrics of a trial on a pose graph: seconds and cpu_s (s, of the solver),
/// ate_mean_m, ate_rmse_m, rotation_mean_deg (after rigid alignment), objective, cost, iterations,
/// closures, accepted, precision, recall, false_share (of the closures), brier, log_loss (of the
/// inlier probabilities). Closures with unknown label do not count.
const std::vector<std::string>& pose_graph_metrics();

/// Ground truth of a closure.
enum class ClosureLabel { kFalse, kTrue, kUnknown };

/// A graph read from its file, with its ground truth.
struct PreparedGraph {
  PoseGraph graph;
  Values initial;
  std::map<Key, mrpt::poses::CPose3D> truth;  ///< empty: nothing is known of it
  std::vector<ClosureLabel> labels;           ///< of the closures of the file, in its order
  /// Without a file of true poses: the cost of the optimum of the true closures that is the truth,
  /// and why there is none.
  std::optional<double> reference_cost;
  std::string no_reference;
};

/// Reads a graph, its true poses and its labels. Without a file of true poses, the best optimum of
/// the true closures from all starts (solve_from_starts) is the truth, if the solver converged.
/// Uses one thread. Throws Error naming the file.
PreparedGraph prepare_graph(const GraphPlan& plan, const std::string& variant);

/// Adds false closures, solves, and compares with the truth. Where nothing is known of that, or a
/// method that takes the true closures alone ends at a lower cost than the reference, there are no
/// errors of poses among the metrics, and the message says why.
TrialResult run_pose_graph_trial(const PreparedGraph& prepared, const Trial& trial,
                                 const MethodOptions& options);

/// Counts of predicted inlier probabilities by tenths of [0, 1], as words `count/true/sum`.
std::string reliability_text(const std::vector<double>& probabilities,
                             const std::vector<bool>& truth);

/// Sums reliability texts into a calibration over closures. Empty texts are ignored.
class ReliabilitySum {
 public:
  /// Brier score and log loss are means per closure. Throws Error for a malformed text.
  void add(const std::string& text, double brier, double log_loss);
  Calibration calibration() const;

 private:
  struct Tenth {
    double count = 0, right = 0, sum = 0;
  };
  std::vector<Tenth> tenths_ = std::vector<Tenth>(10);
  double closures_ = 0, brier_ = 0, log_loss_ = 0;
};

}  // namespace hybrid
