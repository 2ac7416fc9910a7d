// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, the hybrid mapping authors

#include "libhybrid/online/online_selection.h"

#include <fmt/format.h>

#include <set>
#include <unordered_map>
#include <utility>

#include "apps/hybrid-pgo/progress.h"
#include "apps/hybrid-pgo/robust.h"
#include "apps/hybrid-pgo/solution.h"
#include "apps/hybrid-pgo/stopped.h"
#include "libhybrid/core/error.h"
#include "libhybrid/io/read_pairs.h"
#include "libhybrid/pose_graph/pose_feed.h"
#include "libhybrid/pose_graph/pose_graph.h"
#include "libhybrid/pose_graph/vertex_id.h"
#include "libhybrid/selection/part_links.h"
#include "mrpt_plugins/bridge/interrupt.h"

namespace hybrid {
namespace {

using Pairs = std::set<std::pair<std::uint64_t, std::uint64_t>>;

/// The closures listed in a file, all of which must be edges of the graph.
Pairs read_closures(const std::string& file, const Input& input) {
  Pairs known, pairs;
  for (const auto& edge : input.graph.poses2) known.emplace(edge.from.index(), edge.to.index());
  for (const auto& edge : input.graph.poses3) known.emplace(edge.from.index(), edge.to.index());
  const std::size_t first = input.graph.edge_count();
  for (std::size_t f = first; f < first + input.graph.prior_count(); ++f) {
    const std::uint64_t pose = input.factors[f]->keys()[0].index();
    known.emplace(pose, pose);
  }
  for (const VertexPair& pair : read_pairs(file, false)) {
    if (known.count({pair.i, pair.j}) == 0) {
      throw Error(fmt::format("{}:{}: the graph has no edge from {} to {}", file, pair.line, pair.i,
                              pair.j));
    }
    pairs.emplace(pair.i, pair.j);
  }
  return pairs;
}

/// Feeds all poses through `update`, which returns its report.
template <class Selection, class Update>
Solution run(PoseFeed& feed, Selection& selection, const Update& update) {
  Solution solution;
  Progress progress(feed.steps());
  while (!feed.done() && interrupted() == 0) {
    const Key pose = feed.pose();
    const UpdateReport report = update(pose, feed.next(selection.smoother().values()));
    if (report.status != UpdateReport::Status::kOk) {
      throw Error(fmt::format("at pose {}: {}; closures that are not trusted determine nothing",
                              vertex_name(pose.index()), report.message));
    }
    StepRecord record{report};
    record.keyframe = static_cast<std::int64_t>(vertex_id(pose.index()));
    record.time = static_cast<double>(solution.steps.size());
    record.cost = selection.smoother().objective() - selection.smoother().constant();
    record.landmarks = selection.smoother().values().size() - feed.added();
    solution.seconds += report.seconds;
    solution.iterations += report.rounds;
    solution.steps.push_back(record);
    progress.update(solution.steps.size(), record.cost);
  }
  if (feed.done()) {
    solution.cost_online = selection.smoother().cost();
    const UpdateReport report = selection.finish();
    solution.seconds += report.seconds;
    solution.iterations += report.rounds;
    if (report.status != UpdateReport::Status::kOk) solution.message = report.message;
  } else {
    stopped(feed, solution);
  }
  solution.values = selection.smoother().values();
  solution.cost = selection.smoother().cost();
  solution.objective = selection.smoother().objective();
  return solution;
}

/// Which factors are closures in question, and how these join the parts that the others leave.
struct InQuestion {
  std::vector<bool> is_closure;       // by factor of the graph
  std::vector<std::size_t> closures;  // their factors
  JoinedParts joined;

  /// With `trusts_all`, none is.
  InQuestion(const Input& input, bool trusts_all, const Pairs& trusted,
             const ClosureSelectionOptions& options)
      : is_closure(input.factors.size(), false) {
    if (trusts_all) return;
    const std::size_t relative_poses = input.graph.poses2.size() + input.graph.poses3.size();
    RobustProblem problem;
    problem.initial = input.initial;
    for (std::size_t f = 0; f < input.factors.size(); ++f) {
      const std::vector<Key>& keys = input.factors[f]->keys();
      is_closure[f] = (is_in_map(input.graph, f) || (f < relative_poses && input.is_closure[f])) &&
                      trusted.count({keys.front().index(), keys.back().index()}) == 0;
      (is_closure[f] ? problem.closures : problem.trusted).push_back(input.factors[f]);
      if (is_closure[f]) closures.push_back(f);
    }
    joined = join_parts(problem, options);
    for (const PartLink& link : joined.links) is_closure[closures[link.closure]] = false;
  }

  /// Adds what the decisions on the closures say of the links.
  void judge_links(const ClosureSelectionOptions& options, Solution& solution) const {
    if (joined.links.empty() || solution.signal != 0) return;
    RobustResult result;
    result.values = solution.values;
    for (const std::size_t k : joined.closures) {
      result.decisions.push_back(solution.decisions.at(closures[k]));
    }
    const std::vector<ClosureDecision> links = hybrid::judge_links(joined, result, options);
    for (std::size_t k = 0; k < links.size(); ++k) {
      solution.decisions[closures[joined.links[k].closure]] = links[k];
    }
    solution.health = links_health(joined, links);
  }
};

}  // namespace

Solution solve_selection(const Input& input, const std::string& trusted,
                         const OnlineSelectionOptions& options, bool keep_history) {
  const bool trusts_all = trusted.empty() || trusted == "all";
  const Pairs pairs = trusts_all || trusted == "odometry" ? Pairs() : read_closures(trusted, input);
  const InQuestion in_question(input, trusts_all, pairs, options.selection);
  OnlineSelection selection(options);
  PoseFeed feed(input.graph, trusts_all ? input.initial : in_question.joined.problem.initial, {},
                [&](std::size_t f) { return !in_question.is_closure[f]; });
  std::unordered_map<const ContinuousFactor*, std::size_t> number;
  for (std::size_t f = 0; f < feed.factors().size(); ++f) number[feed.factors()[f].get()] = f;
  std::vector<std::size_t> arrived;  // numbers of the closures, in the order of arrival
  std::vector<decltype(ClosureDecision::history)> histories;  // of these closures
  Key newest;
  const auto note_changes = [&] {
    histories.resize(arrived.size());
    for (std::size_t k = 0; keep_history && k < arrived.size(); ++k) {
      const ClosureStatus now = selection.status(k);
      if (!histories[k].empty() && histories[k].back().second == now) continue;
      histories[k].emplace_back(newest.index(), now);
    }
  };
  Solution solution = run(feed, selection, [&](Key pose, Delta delta) {
    newest = pose;
    std::vector<ContinuousFactorPtr> known, closures;
    for (const ContinuousFactorPtr& factor : delta.continuous) {
      const std::size_t f = number.at(factor.get());
      const bool closure = in_question.is_closure[f];
      (closure ? closures : known).push_back(factor);
      if (closure) arrived.push_back(f);
    }
    delta.continuous = std::move(known);
    const UpdateReport report = selection.update(delta, closures);
    if (report.status == UpdateReport::Status::kOk) note_changes();
    return report;
  });
  const std::size_t choices = input.graph.alternatives_count();
  solution.method = choices == 0 ? "incremental, closures selected"
                    : trusts_all ? "incremental, hypotheses decided"
                                 : "incremental, closures selected and hypotheses decided";
  for (std::size_t i = 0; i < choices; ++i) {
    solution.hypotheses.push_back(selection.smoother().assignment().find(hypothesis_key(i)));
  }
  note_changes();
  std::vector<ClosureDecision> decisions = selection.decisions();
  for (std::size_t k = 0; k < arrived.size(); ++k) {
    decisions[k].history = std::move(histories[k]);
    solution.decisions[arrived[k]] = std::move(decisions[k]);
  }
  in_question.judge_links(options.selection, solution);
  return solution;
}

}  // namespace hybrid
