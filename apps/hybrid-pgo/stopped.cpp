// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, the hybrid mapping authors

#include "apps/hybrid-pgo/stopped.h"

#include <fmt/format.h>

#include <map>
#include <vector>

#include "mrpt_plugins/bridge/interrupt.h"

namespace hybrid {
namespace {

constexpr std::size_t kGone = static_cast<std::size_t>(-1);

/// Keeps the edges between variables in `values`; returns the new index of each edge.
template <class Edge>
std::vector<std::size_t> keep(std::vector<Edge>& edges, const Values& values) {
  std::vector<Edge> kept;
  std::vector<std::size_t> numbers;
  for (const Edge& edge : edges) {
    const bool stays = values.contains(edge.from) && values.contains(edge.to);
    numbers.push_back(stays ? kept.size() : kGone);
    if (stays) kept.push_back(edge);
  }
  edges = std::move(kept);
  return numbers;
}

/// Keeps the alternatives of edges that stay, under their new numbers; returns whether each stays.
template <class Pose>
std::vector<bool> keep(std::vector<EdgeAlternatives<Pose>>& alternatives,
                       const std::vector<std::size_t>& numbers) {
  std::vector<bool> stays;
  std::vector<EdgeAlternatives<Pose>> kept;
  for (EdgeAlternatives<Pose>& edge : alternatives) {
    stays.push_back(numbers[edge.edge] != kGone);
    if (!stays.back()) continue;
    edge.edge = numbers[edge.edge];
    kept.push_back(std::move(edge));
  }
  alternatives = std::move(kept);
  return stays;
}

}  // namespace

void stopped(const PoseFeed& feed, Solution& solution) {
  if (solution.steps.empty()) throw_if_interrupted();
  solution.signal = interrupted();
  solution.message = fmt::format("stopped by {} after {} of {} poses", signal_name(solution.signal),
                                 solution.steps.size(), feed.steps());
}

void keep_solved(Input& input, Solution& solution) {
  const Values& values = solution.values;
  PoseGraph& graph = input.graph;
  const std::vector<std::size_t> numbers2 = keep(graph.poses2, values);
  const std::vector<std::size_t> numbers3 = keep(graph.poses3, values);
  keep(graph.points2, values);
  keep(graph.points3, values);
  const std::vector<std::size_t>& numbers = numbers2.empty() ? numbers3 : numbers2;

  std::map<std::size_t, ClosureDecision> decisions;
  for (const auto& [number, decision] : solution.decisions) {
    if (numbers[number] != kGone) decisions[numbers[number]] = decision;
  }
  solution.decisions = std::move(decisions);

  std::vector<bool> is_closure;
  for (std::size_t f = 0; f < numbers.size(); ++f) {
    if (numbers[f] != kGone) is_closure.push_back(input.is_closure[f]);
  }
  input.is_closure = std::move(is_closure);

  std::vector<bool> stays = keep(graph.alternatives2, numbers2);
  const std::vector<bool> stays3 = keep(graph.alternatives3, numbers3);
  stays.insert(stays.end(), stays3.begin(), stays3.end());
  std::vector<int> first, chosen;
  for (std::size_t k = 0; k < stays.size(); ++k) {
    if (!stays[k]) continue;
    first.push_back(input.first_hypotheses[k]);
    chosen.push_back(solution.hypotheses[k]);
  }
  input.first_hypotheses = std::move(first);
  solution.hypotheses = std::move(chosen);

  Values initial;
  for (const Key key : input.initial.keys()) {
    if (values.contains(key)) initial.insert(key, input.initial.type(key), input.initial.data(key));
  }
  input.initial = std::move(initial);
  std::vector<Key> fixed;
  for (const Key key : graph.fixed) {
    if (values.contains(key)) fixed.push_back(key);
  }
  graph.fixed = std::move(fixed);
  input.factors = to_factors(graph, input.initial);
}

}  // namespace hybrid
