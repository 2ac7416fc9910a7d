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

template <class Measured>
bool has_values(const GraphEdge<Measured>& edge, const Values& values) {
  return values.contains(edge.from) && values.contains(edge.to);
}
template <class Pose>
bool has_values(const GraphPrior<Pose>& prior, const Values& values) {
  return values.contains(prior.pose);
}
template <class Point>
bool has_values(const GraphPosition<Point>& position, const Values& values) {
  return values.contains(position.pose);
}

/// New numbers of the factors of a graph whose measurements of variables without values go.
class Kept {
 public:
  explicit Kept(const Values& values) : values_(values) {}

  /// Keeps measurements of variables with values, in the order of `to_factors`.
  template <class Measured>
  void keep(std::vector<Measured>& all) {
    std::vector<Measured> kept;
    for (const Measured& one : all) {
      const bool stays = has_values(one, values_);
      numbers_.push_back(stays ? count_++ : kGone);
      if (stays) kept.push_back(one);
    }
    all = std::move(kept);
  }
  /// The new number of each factor.
  const std::vector<std::size_t>& numbers() const { return numbers_; }

 private:
  const Values& values_;
  std::vector<std::size_t> numbers_;
  std::size_t count_ = 0;
};

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
  Kept kept(values);
  kept.keep(graph.poses2);
  kept.keep(graph.poses3);  // a graph has those of the plane or those of space
  const std::vector<std::size_t> edges = kept.numbers();
  kept.keep(graph.points2);
  kept.keep(graph.points3);
  kept.keep(graph.priors2);
  kept.keep(graph.priors3);
  kept.keep(graph.positions2);
  kept.keep(graph.positions3);
  const std::vector<std::size_t>& numbers = kept.numbers();

  std::map<std::size_t, ClosureDecision> decisions;
  for (const auto& [number, decision] : solution.decisions) {
    if (numbers[number] != kGone) decisions[numbers[number]] = decision;
  }
  solution.decisions = std::move(decisions);

  std::vector<bool> is_closure;
  for (std::size_t f = 0; f < edges.size(); ++f) {
    if (edges[f] != kGone) is_closure.push_back(input.is_closure[f]);
  }
  input.is_closure = std::move(is_closure);

  std::vector<bool> stays = keep(graph.alternatives2, edges);
  const std::vector<bool> stays3 = keep(graph.alternatives3, edges);
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
