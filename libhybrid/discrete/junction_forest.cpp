// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, the hybrid mapping authors
#include "libhybrid/discrete/junction_forest.h"

#include <algorithm>
#include <cstdint>
#include <functional>
#include <iterator>
#include <limits>
#include <numeric>
#include <queue>
#include <tuple>

namespace hybrid {
namespace {

constexpr std::int64_t kTooLarge = std::numeric_limits<std::int64_t>::max();

/// The elimination game on the graph that joins variables which share a table.
class Ordering {
 public:
  Ordering(const DiscreteGraph& graph, const TableLimits& limits, bool with_singles)
      : graph_(graph),
        limits_(limits),
        gone_(graph.size(), 0),
        charged_(graph.component_count(), 0.0) {
    if (!with_singles) {
      for (int v = 0; v < graph.size(); ++v) {
        gone_[v] = graph.component_variables(graph.component(v)).size() == 1;
      }
    }
    separator_begin_.push_back(0);
    find_neighbours();
  }

  JunctionForest run() {
    strip_leaves();
    if (std::find(gone_.begin(), gone_.end(), 0) != gone_.end()) eliminate_core();
    return finish();
  }

 private:
  // Fill (kTooLarge: over the limits), table entries, variable, version of the score.
  using Score = std::tuple<std::int64_t, double, int, int>;

  void find_neighbours();
  void strip_leaves();
  void eliminate_core();
  void connect(const std::vector<int>& clique);
  void touch(int v);
  void score(int v);
  void record(int v, const int* first, const int* last, double entries);
  void refuse(int v, double entries);
  void share_total();
  JunctionForest finish();

  /// Whether one more table of the component of v keeps it within the limits.
  bool fits(int v, double entries) const {
    return entries <= static_cast<double>(limits_.max_table) &&
           charged_[graph_.component(v)] + entries <= static_cast<double>(limits_.max_total);
  }

  const DiscreteGraph& graph_;
  const TableLimits limits_;
  std::vector<char> gone_;
  std::vector<int> begin_;  // neighbours in the original graph: begin_[v] .. + degree_[v]
  std::vector<int> neighbours_;
  std::vector<int> degree_;
  std::vector<int> live_;        // neighbours not yet eliminated
  std::vector<double> charged_;  // table entries so far, by component

  std::vector<std::vector<int>> adjacent_;  // neighbours in the core, sorted
  std::vector<int> version_;
  std::vector<int> touched_;
  std::vector<char> is_touched_;
  std::priority_queue<Score, std::vector<Score>, std::greater<Score>> queue_;

  std::vector<int> order_;
  std::vector<double> entries_;
  std::vector<int> separator_begin_;
  std::vector<int> separators_;  // variable ids
  std::vector<TooLarge> too_large_;
};

void Ordering::find_neighbours() {
  begin_.assign(graph_.size() + 1, 0);
  const int tables = static_cast<int>(graph_.tables().size());
  for (int t = 0; t < tables; ++t) {
    for (int v : graph_.scope(t)) begin_[v + 1] += graph_.scope(t).size() - 1;
  }
  for (int v = 0; v < graph_.size(); ++v) begin_[v + 1] += begin_[v];
  neighbours_.resize(begin_.back());
  degree_.assign(graph_.size(), 0);
  for (int t = 0; t < tables; ++t) {
    for (int v : graph_.scope(t)) {
      for (int u : graph_.scope(t)) {
        if (u != v) neighbours_[begin_[v] + degree_[v]++] = u;
      }
    }
  }
  for (int v = 0; v < graph_.size(); ++v) {
    const auto first = neighbours_.begin() + begin_[v];
    std::sort(first, first + degree_[v]);
    degree_[v] = static_cast<int>(std::unique(first, first + degree_[v]) - first);
  }
  live_ = degree_;
}

// Eliminates leaves until none is left, which eliminates trees whole. A variable with one neighbour
// adds no edge, so that the order below would choose it first as well.
void Ordering::strip_leaves() {
  std::vector<int> leaves;
  for (int v = 0; v < graph_.size(); ++v) {
    if (!gone_[v] && degree_[v] <= 1) leaves.push_back(v);
  }
  for (std::size_t i = 0; i < leaves.size(); ++i) {
    const int v = leaves[i];
    const int* first = neighbours_.data() + begin_[v];
    const int* other = std::find_if(first, first + degree_[v], [&](int u) { return !gone_[u]; });
    const bool is_root = live_[v] == 0;
    const double entries =
        is_root ? graph_.cardinality(v) : 1.0 * graph_.cardinality(v) * graph_.cardinality(*other);
    if (!fits(v, entries)) continue;
    record(v, other, other + (is_root ? 0 : 1), entries);
    if (!is_root && --live_[*other] == 1) leaves.push_back(*other);
  }
}

void Ordering::eliminate_core() {
  adjacent_.resize(graph_.size());
  version_.assign(graph_.size(), 0);
  is_touched_.assign(graph_.size(), 0);
  for (int v = 0; v < graph_.size(); ++v) {
    if (gone_[v]) continue;
    std::copy_if(neighbours_.begin() + begin_[v], neighbours_.begin() + begin_[v] + degree_[v],
                 std::back_inserter(adjacent_[v]), [&](int u) { return !gone_[u]; });
  }
  for (int v = 0; v < graph_.size(); ++v) {
    if (!gone_[v]) score(v);
  }
  while (!queue_.empty()) {
    const auto [fill, entries, v, version] = queue_.top();
    queue_.pop();
    if (gone_[v] || version != version_[v]) continue;
    if (fill == kTooLarge || !fits(v, entries)) {
      refuse(v, entries);
      continue;
    }
    const std::vector<int> clique = std::move(adjacent_[v]);
    record(v, clique.data(), clique.data() + clique.size(), entries);
    for (int u : clique) {
      adjacent_[u].erase(std::lower_bound(adjacent_[u].begin(), adjacent_[u].end(), v));
      touch(u);
    }
    connect(clique);
    for (int u : touched_) {
      is_touched_[u] = 0;
      score(u);
    }
    touched_.clear();
  }
}

// Adds the edges missing in a clique. The fill of the common neighbours of a new edge changes.
void Ordering::connect(const std::vector<int>& clique) {
  for (std::size_t i = 0; i < clique.size(); ++i) {
    for (std::size_t j = i + 1; j < clique.size(); ++j) {
      std::vector<int>& a = adjacent_[clique[i]];
      std::vector<int>& b = adjacent_[clique[j]];
      const auto place = std::lower_bound(a.begin(), a.end(), clique[j]);
      if (place != a.end() && *place == clique[j]) continue;
      std::vector<int> common;
      std::set_intersection(a.begin(), a.end(), b.begin(), b.end(), std::back_inserter(common));
      for (int u : common) touch(u);
      a.insert(place, clique[j]);
      b.insert(std::lower_bound(b.begin(), b.end(), clique[i]), clique[i]);
    }
  }
}

void Ordering::touch(int v) {
  if (is_touched_[v]) return;
  is_touched_[v] = 1;
  touched_.push_back(v);
}

void Ordering::score(int v) {
  const std::vector<int>& around = adjacent_[v];
  double entries = graph_.cardinality(v);
  for (int u : around) entries *= graph_.cardinality(u);
  std::int64_t fill = kTooLarge;
  if (entries <= static_cast<double>(limits_.max_table)) {
    fill = 0;
    for (std::size_t i = 0; i < around.size(); ++i) {
      const std::vector<int>& seen = adjacent_[around[i]];
      for (std::size_t j = i + 1; j < around.size(); ++j) {
        fill += !std::binary_search(seen.begin(), seen.end(), around[j]);
      }
    }
  }
  queue_.emplace(fill, entries, v, ++version_[v]);
}

void Ordering::record(int v, const int* first, const int* last, double entries) {
  gone_[v] = 1;
  charged_[graph_.component(v)] += entries;
  order_.push_back(v);
  entries_.push_back(entries);
  separators_.insert(separators_.end(), first, last);
  separator_begin_.push_back(static_cast<int>(separators_.size()));
}

void Ordering::refuse(int v, double entries) {
  too_large_.push_back({graph_.component(v), {v}, entries});
  std::vector<int>& variables = too_large_.back().variables;
  variables.insert(variables.end(), adjacent_[v].begin(), adjacent_[v].end());
  for (int u : graph_.component_variables(graph_.component(v))) gone_[u] = 1;
}

// Grants the limit on all tables together to the smallest components first, so that as many as
// possible are exact.
void Ordering::share_total() {
  std::vector<char> refused(graph_.component_count(), 0);
  for (const TooLarge& failure : too_large_) refused[failure.component] = 1;
  std::vector<int> ascending(graph_.component_count());
  std::iota(ascending.begin(), ascending.end(), 0);
  std::stable_sort(ascending.begin(), ascending.end(),
                   [&](int a, int b) { return charged_[a] < charged_[b]; });
  double total = 0.0;
  for (int c : ascending) {
    if (refused[c]) continue;
    total += charged_[c];
    if (total <= static_cast<double>(limits_.max_total)) continue;
    const IntSpan variables = graph_.component_variables(c);
    too_large_.push_back({c, {variables.begin(), variables.end()}, charged_[c]});
  }
}

JunctionForest Ordering::finish() {
  share_total();
  std::vector<char> refused(graph_.component_count(), 0);
  for (const TooLarge& failure : too_large_) refused[failure.component] = 1;
  JunctionForest forest;
  forest.position.assign(graph_.size(), -1);
  forest.order.reserve(order_.size());
  for (int v : order_) {
    if (refused[graph_.component(v)]) continue;
    forest.position[v] = forest.size();
    forest.order.push_back(v);
  }
  forest.entries.reserve(order_.size());
  forest.separators.reserve(separators_.size());
  forest.separator_begin.reserve(order_.size() + 1);
  forest.separator_begin.push_back(0);
  for (std::size_t i = 0; i < order_.size(); ++i) {
    if (refused[graph_.component(order_[i])]) continue;
    const std::size_t begin = forest.separators.size();
    for (int k = separator_begin_[i]; k < separator_begin_[i + 1]; ++k) {
      forest.separators.push_back(forest.position[separators_[k]]);
    }
    std::sort(forest.separators.begin() + begin, forest.separators.end(), std::greater<int>());
    forest.separator_begin.push_back(static_cast<int>(forest.separators.size()));
    forest.entries.push_back(static_cast<std::size_t>(entries_[i]));
  }
  forest.too_large = std::move(too_large_);
  return forest;
}

}  // namespace

JunctionForest make_junction_forest(const DiscreteGraph& graph, const TableLimits& limits,
                                    bool with_singles) {
  return Ordering(graph, limits, with_singles).run();
}

}  // namespace hybrid
