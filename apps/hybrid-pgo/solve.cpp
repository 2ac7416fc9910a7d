// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, the hybrid mapping authors

#include <fmt/format.h>

#include "apps/hybrid-pgo/progress.h"
#include "apps/hybrid-pgo/solution.h"
#include "apps/hybrid-pgo/stopped.h"
#include "libhybrid/core/error.h"
#include "libhybrid/pose_graph/pose_feed.h"
#include "libhybrid/pose_graph/vertex_id.h"
#include "libhybrid/smoother/incremental.h"
#include "mrpt_plugins/bridge/interrupt.h"

namespace hybrid {
namespace {

/// One update of the smoother. `normalizer` is the sum of the log-normalisers of all factors so
/// far: the difference between objective and cost.
StepRecord step(IncrementalSmoother& smoother, PoseFeed& feed, double& normalizer) {
  const Key pose = feed.pose();
  const Delta delta = feed.next(smoother.values());
  for (const auto& factor : delta.continuous) normalizer += factor->log_normalizer();
  const UpdateReport report = smoother.update(delta);
  if (report.status != UpdateReport::Status::kOk) {
    throw Error(fmt::format("at pose {}: {}", vertex_name(pose.index()), report.message));
  }
  StepRecord record{report};
  record.keyframe = static_cast<std::int64_t>(vertex_id(pose.index()));
  record.cost = report.objective_after - normalizer;
  return record;
}

}  // namespace

Solution solve_batch(const Input& input, bool compare, const SolverOptions& options) {
  Solution solution;
  solution.method = "lm";
  const HybridGraph graph(input.factors);
  std::vector<Start> starts =
      pose_graph_starts(input.graph, input.factors, input.start, input.initial);
  if (!compare) starts.resize(1);
  StartsResult result = solve_from_starts(graph, starts, options);
  const SolverReport& report = result.report;
  if (report.status == SolverStatus::kIterationLimit) {
    solution.message = fmt::format(
        "stopped after {} iterations before it converged{}; --set solver.{}=N allows more",
        report.iterations,
        result.met_operations ? ", for the measurements link far more poses than a map does, as "
                                "false loop closures do"
                              : "",
        result.met_operations ? "max_operations" : "max_iterations");
  } else if (report.status == SolverStatus::kStalled) {
    solution.message = report.message;
  } else if (report.status != SolverStatus::kConverged) {
    throw Error(to_string(report.status) + ": " + report.message);
  }
  solution.values = result.values;
  solution.start = result.trials[result.won].name;
  if (result.trials.size() > 1) solution.starts = std::move(result.trials);
  solution.iterations = report.iterations;
  solution.seconds = report.seconds;
  solution.cost = cost(graph, solution.values, {});
  solution.objective = objective(graph, solution.values, {});
  for (const double cost : report.costs) {
    solution.objectives.push_back(cost + solution.objective - solution.cost);
  }
  return solution;
}

Solution solve_online(const Input& input) {
  Solution solution;
  solution.method = "incremental";
  IncrementalSmoother smoother;
  PoseFeed feed(input.graph, input.initial);
  Progress progress(feed.steps());
  double normalizer = 0;
  while (!feed.done() && interrupted() == 0) {
    solution.steps.push_back(step(smoother, feed, normalizer));
    StepRecord& last = solution.steps.back();
    last.time = static_cast<double>(solution.steps.size() - 1);
    last.landmarks = smoother.values().size() - feed.added();
    solution.seconds += last.seconds;
    solution.iterations += last.rounds;
    progress.update(solution.steps.size(), last.cost);
  }
  if (feed.done()) {
    solution.cost_online = smoother.cost();
    const UpdateReport report = smoother.converge();
    solution.seconds += report.seconds;
    solution.iterations += report.rounds;
    if (report.status != UpdateReport::Status::kOk) solution.message = report.message;
  } else {
    stopped(feed, solution);
  }
  solution.values = smoother.values();
  solution.cost = smoother.cost();
  solution.objective = smoother.objective();
  return solution;
}

}  // namespace hybrid
