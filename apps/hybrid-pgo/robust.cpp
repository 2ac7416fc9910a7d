// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, the hybrid mapping authors

#include "apps/hybrid-pgo/robust.h"

#include <fmt/format.h>

#include <algorithm>
#include <map>
#include <set>
#include <utility>

#include "libhybrid/closures/mixture_graph.h"
#include "libhybrid/closures/objective_bound.h"
#include "libhybrid/core/error.h"
#include "libhybrid/io/read_pairs.h"
#include "libhybrid/pose_graph/pose_graph.h"
#include "libhybrid/selection/closure_posterior.h"
#include "libhybrid/selection/part_links.h"
#include "mrpt_plugins/health/closures.h"

namespace hybrid {
namespace {

using Pair = std::pair<std::uint64_t, std::uint64_t>;

/// Reads rows `i j` or `i j flag`; a missing flag is 1.
std::map<Pair, bool> read_flags(const std::string& file) {
  std::map<Pair, bool> flags;
  for (const VertexPair& pair : read_pairs(file, true)) flags[{pair.i, pair.j}] = pair.flag;
  return flags;
}

bool has_flags(const std::map<Pair, bool>& pairs) {
  for (const auto& [pair, flag] : pairs) {
    if (!flag) return true;
  }
  return false;
}

/// Whether any pair is of a measurement in the frame of the map.
bool names_in_map(const std::map<Pair, bool>& pairs) {
  return std::any_of(pairs.begin(), pairs.end(),
                     [](const auto& pair) { return pair.first.first == pair.first.second; });
}

/// The robust problem of one part, with the index in `loops` of each closure and of each link.
struct Task : RobustTask {
  JoinedParts joined;
  std::vector<std::size_t> loop_of, loop_of_link;
};

Task make_task(const Input& input, const Options& options, std::vector<Loop>& loops) {
  std::map<Pair, bool> trusted;
  const bool by_file = !options.trusted.empty() && options.trusted != "odometry";
  if (by_file) trusted = read_flags(options.trusted);
  Task task;
  const std::size_t relative_poses = input.graph.poses2.size() + input.graph.poses3.size();
  std::vector<std::size_t> loop_of;  // of closures that are not trusted, asked in order
  task.problem.initial = input.initial;
  for (std::size_t f = 0; f < input.factors.size(); ++f) {
    const ContinuousFactorPtr& factor = input.factors[f];
    const Key from = factor->keys().front(), to = factor->keys().back();
    const bool in_map = is_in_map(input.graph, f);
    const bool odometry = !in_map && (f >= relative_poses || !input.is_closure[f]);
    const auto named = trusted.find({from.index(), to.index()});
    const bool is_named = named != trusted.end() && named->second;
    const bool trust = f >= relative_poses && !in_map ? true : by_file ? is_named : odometry;
    if (!odometry || !trust) loops.push_back({from, to, f});
    if (!trust) loop_of.push_back(loops.size() - 1);
    (trust ? task.problem.trusted : task.problem.closures).push_back(factor);
  }
  task.joined = join_parts(task.problem, options.methods.portfolio.selection);
  task.problem = task.joined.problem;
  for (const std::size_t k : task.joined.closures) task.loop_of.push_back(loop_of[k]);
  for (const PartLink& link : task.joined.links) {
    task.loop_of_link.push_back(loop_of[link.closure]);
  }
  if (options.labels.empty()) return task;
  const std::map<Pair, bool> labels = read_flags(options.labels);
  const bool of_map = names_in_map(labels);
  for (const ContinuousFactorPtr& closure : task.problem.closures) {
    const Key from = closure->keys().front(), to = closure->keys().back();
    const auto label = labels.find({from.index(), to.index()});
    const bool is_true = label != labels.end() && label->second;
    task.truth.push_back(is_true || (from == to && !of_map));
  }
  return task;
}

}  // namespace

Solution solve_robust(const Input& input, const Options& options, std::vector<Loop>& loops) {
  const Task task = make_task(input, options, loops);
  RobustResult result = robust_method(options.method).solve(task, options.methods);
  integrate_poses(task.problem, options.methods.common.mixture, result);
  Solution solution;
  solution.method = options.method;
  solution.values = result.values;
  solution.iterations = result.iterations;
  solution.seconds = result.seconds;
  solution.objective = result.objective;
  solution.cost = result.cost;
  solution.variance_factor = result.variance_factor;
  solution.members = result.members;
  solution.objectives = result.objectives;
  if (!result.converged) solution.message = result.message;
  for (std::size_t k = 0; k < result.decisions.size(); ++k) {
    loops[task.loop_of[k]].decision = result.decisions[k];
  }
  const std::vector<ClosureDecision> links =
      judge_links(task.joined, result, options.methods.portfolio.selection);
  for (std::size_t k = 0; k < links.size(); ++k) {
    loops[task.loop_of_link[k]].decision = links[k];
  }
  solution.health = links_health(task.joined, links);
  return solution;
}

Health links_health(const JoinedParts& joined, const std::vector<ClosureDecision>& links) {
  std::vector<ClosureDecision> of_parts;
  for (std::size_t k = 0; k < links.size(); ++k) {
    if (!joined.links[k].to_map) of_parts.push_back(links[k]);
  }
  return parts_health(of_parts, joined.candidates);
}

double discrete_gap(const Input& input, const Options& options, const std::vector<Loop>& loops,
                    const Values& values, int budget) {
  std::vector<Loop> all_loops;
  const Task task = make_task(input, options, all_loops);
  std::vector<bool> accepted;
  for (const std::size_t loop : task.loop_of)
    accepted.push_back(loops.at(loop).decision.in_force());
  return bound_objective(task.problem, values, accepted, options.methods.common.mixture, budget)
      .gap;
}

void compare_with_labels(const std::string& file, const std::vector<Loop>& loops,
                         TruthSummary& truth) {
  const std::map<Pair, bool> labels = read_flags(file);
  const bool others_unknown = has_flags(labels), of_map = names_in_map(labels);
  double accepted = 0, accepted_true = 0, all_true = 0;
  for (const Loop& loop : loops) {
    const auto label = labels.find({loop.from.index(), loop.to.index()});
    if (label == labels.end() && (others_unknown || (loop.in_map() && !of_map))) continue;
    const bool is_true = label != labels.end() && label->second;
    const bool in = loop.decision.in_force();
    accepted += in;
    accepted_true += in && is_true;
    all_true += is_true;
  }
  if (accepted > 0) truth.loop_precision = accepted_true / accepted;
  if (all_true > 0) truth.loop_recall = accepted_true / all_true;
}

}  // namespace hybrid
