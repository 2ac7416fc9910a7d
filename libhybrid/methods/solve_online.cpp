// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, the hybrid mapping authors
#include "libhybrid/methods/solve_online.h"

#include <unordered_map>
#include <utility>

#include "libhybrid/core/elapsed.h"
#include "libhybrid/pose_graph/pose_feed.h"
#include "libhybrid/pose_graph/pose_graph.h"
#include "libhybrid/pose_graph/vertex_id.h"

namespace hybrid {

RobustResult solve_online(const PoseGraph& graph, const Values& initial, const Trust& trusted,
                          const OnlineSelectionOptions& options) {
  const auto start = std::chrono::steady_clock::now();
  PoseFeed feed(graph, initial);
  const Trust trust = trusted ? trusted : OdometryEdges(graph);
  const std::size_t relative_poses = graph.poses2.size() + graph.poses3.size();
  std::unordered_map<const ContinuousFactor*, std::size_t> number;  // among the closures
  for (std::size_t f = 0; f < relative_poses; ++f) {
    const ContinuousFactor& factor = *feed.factors()[f];
    if (!trust(factor.keys()[0], factor.keys()[1])) number.emplace(&factor, number.size());
  }
  OnlineSelection selection(options);
  RobustResult result;
  result.method = "online";
  std::vector<std::size_t> order;  // numbers of the closures, as they arrive
  while (!feed.done()) {
    const Key pose = feed.pose();
    Delta delta = feed.next(selection.smoother().values());
    std::vector<ContinuousFactorPtr> known, closures;
    for (const ContinuousFactorPtr& factor : delta.continuous) {
      const auto closure = number.find(factor.get());
      (closure == number.end() ? known : closures).push_back(factor);
      if (closure != number.end()) order.push_back(closure->second);
    }
    delta.continuous = std::move(known);
    const SelectionReport report = selection.update(delta, closures);
    if (report.status != UpdateReport::Status::kOk) {
      throw Error("at pose " + vertex_name(pose.index()) + ": " +
                  with_vertex_names(report.message));
    }
    result.iterations += report.rounds;
  }
  result.iterations += selection.finish().rounds;
  result.values = selection.smoother().values();
  result.cost = selection.smoother().cost();
  result.objective = selection.smoother().objective();
  const std::vector<ClosureDecision> decisions = selection.decisions();
  result.decisions.resize(order.size());
  for (std::size_t k = 0; k < order.size(); ++k) result.decisions[order[k]] = decisions[k];
  result.poses_integrated = true;  // by the last evaluation of all
  result.seconds = seconds_since(start);
  return result;
}

}  // namespace hybrid
