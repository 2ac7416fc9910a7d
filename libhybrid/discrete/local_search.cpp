// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, the hybrid mapping authors
#include "libhybrid/discrete/detail/local_search.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <utility>

#include "libhybrid/core/sort_unique.h"
#include "libhybrid/discrete/detail/variable_elimination.h"

namespace hybrid {
namespace {

/// Descent over one component.
class Search {
 public:
  Search(const DiscreteGraph& graph, int component, std::vector<int>& values);

  /// True if the cost fell.
  bool sweep(bool backwards);

 private:
  std::vector<int> grow_forest(const std::vector<int>& order, int start);
  bool joins_forest(int v);
  int tree(int v);
  bool improve(const std::vector<int>& block);
  Table slice(int t) const;
  double entry(int t, std::size_t index) const {
    const double c = graph_.tables()[t]->costs()[index];
    return std::isfinite(c) ? c : penalty_[t];
  }
  double cost(const std::vector<int>& tables) const;

  const DiscreteGraph& graph_;
  std::vector<int>& values_;
  std::vector<int> variables_;
  std::vector<std::vector<int>> tables_of_;  // by variable id
  std::vector<double> penalty_;              // by table: the cost that replaces infinity
  std::vector<int> tree_;                    // by variable id: union-find; -1 outside the block
  std::vector<int> roots_;
  std::vector<char> covered_;
};

Search::Search(const DiscreteGraph& graph, int component, std::vector<int>& values)
    : graph_(graph),
      values_(values),
      variables_(graph.component_variables(component).begin(),
                 graph.component_variables(component).end()),
      tables_of_(graph.size()),
      penalty_(graph.tables().size()),
      tree_(graph.size(), -1),
      covered_(graph.size()) {
  double span = 1.0;
  for (int t : graph_.component_tables(component)) {
    for (int v : graph_.scope(t)) tables_of_[v].push_back(t);
    double least = 0.0, most = 0.0;
    bool any = false;
    for (double c : graph_.tables()[t]->costs()) {
      if (!std::isfinite(c)) continue;
      least = any ? std::min(least, c) : c;
      most = any ? std::max(most, c) : c;
      any = true;
    }
    penalty_[t] = least;
    span += most - least;
  }
  for (int t : graph_.component_tables(component)) penalty_[t] += 2.0 * span;
}

bool Search::sweep(bool backwards) {
  std::vector<int> order = variables_;
  if (backwards) std::reverse(order.begin(), order.end());
  for (int v : order) covered_[v] = 0;
  bool improved = false;
  for (std::size_t start = 0; start < order.size(); ++start) {
    if (covered_[order[start]]) continue;
    const std::vector<int> block = grow_forest(order, static_cast<int>(start));
    improved = improve(block) || improved;
    for (int v : block) tree_[v] = -1;
  }
  return improved;
}

// Takes, cyclically from `start`, every variable whose neighbours in the block are in different
// trees.
std::vector<int> Search::grow_forest(const std::vector<int>& order, int start) {
  std::vector<int> block;
  for (std::size_t i = 0; i < order.size(); ++i) {
    const int v = order[(start + i) % order.size()];
    if (!joins_forest(v)) continue;
    tree_[v] = v;
    for (int root : roots_) tree_[root] = v;
    covered_[v] = 1;
    block.push_back(v);
  }
  return block;
}

bool Search::joins_forest(int v) {
  roots_.clear();
  std::vector<int> seen;
  for (int t : tables_of_[v]) {
    for (int u : graph_.scope(t)) {
      if (u == v || tree_[u] < 0) continue;
      if (std::find(seen.begin(), seen.end(), u) != seen.end()) continue;
      const int root = tree(u);
      if (std::find(roots_.begin(), roots_.end(), root) != roots_.end()) return false;
      seen.push_back(u);
      roots_.push_back(root);
    }
  }
  return true;
}

int Search::tree(int v) {
  while (tree_[v] != v) v = tree_[v] = tree_[tree_[v]];
  return v;
}

// A table conditioned on its variables outside the block.
Table Search::slice(int t) const {
  std::vector<DiscreteKey> keys;
  std::vector<std::size_t> steps;
  std::size_t base = 0;
  std::size_t step = 1;
  const IntSpan scope = graph_.scope(t);
  for (int i = scope.size() - 1; i >= 0; --i) {
    const int v = scope[i];
    if (tree_[v] >= 0) {
      keys.push_back(graph_.variables()[v]);
      steps.push_back(step);
    } else {
      base += step * values_[v];
    }
    step *= graph_.cardinality(v);
  }
  std::vector<double> costs(joint_size(keys));
  for (std::size_t i = 0; i < costs.size(); ++i) {
    std::size_t index = base;
    std::size_t rest = i;
    for (std::size_t k = keys.size(); k-- > 0;) {
      index += rest % keys[k].cardinality * steps[k];
      rest /= keys[k].cardinality;
    }
    costs[i] = entry(t, index);
  }
  return {std::move(keys), std::move(costs)};
}

double Search::cost(const std::vector<int>& tables) const {
  double sum = 0.0;
  for (int t : tables) {
    std::size_t index = 0;
    for (int v : graph_.scope(t)) index = index * graph_.cardinality(v) + values_[v];
    sum += entry(t, index);
  }
  return sum;
}

bool Search::improve(const std::vector<int>& block) {
  std::vector<int> touched;
  for (int v : block) touched.insert(touched.end(), tables_of_[v].begin(), tables_of_[v].end());
  sort_unique(touched);
  std::vector<Table> slices;
  slices.reserve(touched.size());
  for (int t : touched) slices.push_back(slice(t));
  std::vector<const Table*> pointers;
  for (const Table& table : slices) pointers.push_back(&table);
  const DiscreteGraph inner(std::move(pointers));

  // Variables of the block by their id in the inner graph.
  std::vector<int> outer;
  std::vector<char> met(graph_.size(), 0);
  for (int t : touched) {
    const IntSpan scope = graph_.scope(t);
    for (int i = scope.size() - 1; i >= 0; --i) {
      if (tree_[scope[i]] < 0 || std::exchange(met[scope[i]], 1)) continue;
      outer.push_back(scope[i]);
    }
  }
  std::vector<int> best;
  for (int v : outer) best.push_back(values_[v]);
  // No limit is needed: a table has at most two variables in the forest, so that no clique is
  // larger than the tables.
  const std::size_t any = std::numeric_limits<std::size_t>::max();
  const JunctionForest forest = make_junction_forest(inner, {any, any}, true);
  VariableElimination(inner, forest).minimize(best);

  const double before = cost(touched);
  for (std::size_t i = 0; i < outer.size(); ++i) std::swap(values_[outer[i]], best[i]);
  if (cost(touched) < before - 1e-12 * std::max(1.0, std::abs(before))) return true;
  for (std::size_t i = 0; i < outer.size(); ++i) values_[outer[i]] = best[i];
  return false;
}

}  // namespace

void local_search(const DiscreteGraph& graph, int component, int max_sweeps,
                  std::vector<int>& values) {
  Search search(graph, component, values);
  for (int i = 0; i < max_sweeps; ++i) {
    if (!search.sweep(i % 2 == 1)) return;
  }
}

}  // namespace hybrid
