// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, the hybrid mapping authors

#pragma once

#include <cstddef>
#include <string>
#include <vector>

#include "apps/hybrid-pgo/solution.h"
#include "libhybrid/closures/closure_decision.h"
#include "mrpt_plugins/bridge/output_directory.h"
#include "mrpt_plugins/drawing/image.h"
#include "mrpt_plugins/evaluation/trajectory_metrics.h"
#include "mrpt_plugins/report/graph_report.h"

namespace hybrid {

/// A loop closure and the decision about it; or a pose or position of `from` in the frame of the
/// map.
struct Loop {
  Key from, to;            ///< the same pose twice for a measurement in the frame of the map
  std::size_t factor = 0;  ///< its number in the input
  ClosureDecision decision = ClosureDecision::trusted();

  bool in_map() const { return from == to; }
};

/// All loop closures of a graph in the order of the file, then what is measured in the map.
std::vector<Loop> find_loops(const Input& input, const Values& estimate,
                             const std::map<std::size_t, ClosureDecision>& decisions);

/// For each factor of the input the loop that it belongs to, null for what is not in question.
std::vector<const Loop*> loops_of_factors(const Input& input, const std::vector<Loop>& loops);

/// hypotheses.csv: i, j, chosen hypothesis, and the position of the hypothesis that was first in
/// the file.
std::string hypotheses_csv(const Input& input, const std::vector<int>& chosen);

/// loops.csv: i, j, decision, inlier_probability, residual, redundancy, checkable, margin.
std::string loops_csv(const std::vector<Loop>& loops);

/// graph.g2o: the estimate with the measurements of the input.
void write_graph(const OutputDirectory& out, const Input& input, const Values& estimate);

/// Ids of the poses that have values, in the order of `poses`, as their file has them.
std::vector<std::string> ids_of(const std::vector<Key>& poses, const Values& values);

/// Poses by increasing id, with the id as time.
Trajectory trajectory_of(const std::vector<Key>& poses, const Values& values);

/// Draws graph_start.png (the initial poses with all measurements) and graph.png.
void draw_graph(const OutputDirectory& out, PictureFormat format, const std::string& title,
                const Input& input, const Solution& solution, const std::vector<Loop>& loops,
                const std::vector<PosePair>& truth);

/// The content of report.html.
GraphReport graph_report(const std::string& title, const Input& input, const Solution& solution,
                         const std::vector<Loop>& loops, const std::vector<PosePair>& truth);

}  // namespace hybrid
