// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, the hybrid mapping authors
#include "libhybrid/discrete/graph.h"

#include <algorithm>
#include <string>
#include <utility>

namespace hybrid {
namespace {

/// Ids of keys by open addressing: one array, so that a look-up is one cache line.
class KeyIds {
 public:
  explicit KeyIds(std::size_t expected) {
    std::size_t capacity = 16;
    while (capacity < 2 * expected) capacity *= 2;
    slots_.resize(capacity);
  }

  /// The id of a key; a new key gets the id `next`.
  int find_or_add(Key key, int next) {
    std::size_t i = std::hash<Key>{}(key) & (slots_.size() - 1);
    while (slots_[i].id >= 0) {
      if (slots_[i].key == key) return slots_[i].id;
      i = (i + 1) & (slots_.size() - 1);
    }
    slots_[i] = {key, next};
    return next;
  }

 private:
  struct Slot {
    Key key;
    int id = -1;
  };
  std::vector<Slot> slots_;
};

int find_root(std::vector<int>& parent, int v) {
  while (parent[v] != v) v = parent[v] = parent[parent[v]];
  return v;
}

/// Turns the counts of groups into the index of the first item of every group; the last entry
/// becomes the total.
void counts_to_begins(std::vector<int>& counts) {
  int sum = 0;
  for (int& count : counts) sum += std::exchange(count, sum);
}

}  // namespace

DiscreteGraph::DiscreteGraph(std::vector<const Table*> tables) : tables_(std::move(tables)) {
  index_variables();
  split_components();
}

void DiscreteGraph::index_variables() {
  std::size_t total = 0;
  for (const Table* table : tables_) total += table->keys().size();
  KeyIds ids(total);
  scope_.reserve(total);
  scope_begin_.reserve(tables_.size() + 1);
  scope_begin_.push_back(0);
  for (const Table* table : tables_) {
    for (const DiscreteKey& key : table->keys()) {
      const int id = ids.find_or_add(key.key, size());
      if (id == size()) {
        variables_.push_back(key);
      } else if (variables_[id].cardinality != key.cardinality) {
        throw Error("discrete variable " + to_string(key.key) + " has " +
                    std::to_string(variables_[id].cardinality) + " values in one table and " +
                    std::to_string(key.cardinality) + " in another");
      }
      scope_.push_back(id);
    }
    scope_begin_.push_back(static_cast<int>(scope_.size()));
  }
}

void DiscreteGraph::split_components() {
  std::vector<int> parent(size());
  for (int v = 0; v < size(); ++v) parent[v] = v;
  const int table_count = static_cast<int>(tables_.size());
  for (int t = 0; t < table_count; ++t) {
    const IntSpan s = scope(t);
    for (int i = 1; i < s.size(); ++i) {
      const int a = find_root(parent, s[0]);
      const int b = find_root(parent, s[i]);
      // The smaller id stays the root, so that components are met in order of their first variable.
      parent[std::max(a, b)] = std::min(a, b);
    }
  }
  component_.resize(size());
  int count = 0;
  for (int v = 0; v < size(); ++v) {
    const int root = find_root(parent, v);
    component_[v] = root == v ? count++ : component_[root];
  }
  variables_begin_.assign(count + 1, 0);
  tables_begin_.assign(count + 1, 0);
  for (int v = 0; v < size(); ++v) ++variables_begin_[component_[v]];
  int with_variables = 0;
  for (int t = 0; t < table_count; ++t) {
    if (scope(t).size() == 0) continue;
    ++tables_begin_[component_[scope(t)[0]]];
    ++with_variables;
  }
  counts_to_begins(variables_begin_);
  counts_to_begins(tables_begin_);
  by_component_.resize(size());
  tables_by_component_.resize(with_variables);
  std::vector<int> next = variables_begin_;
  for (int v = 0; v < size(); ++v) by_component_[next[component_[v]]++] = v;
  next = tables_begin_;
  for (int t = 0; t < table_count; ++t) {
    if (scope(t).size() > 0) tables_by_component_[next[component_[scope(t)[0]]]++] = t;
  }
}

double DiscreteGraph::cost(int table, const std::vector<int>& values) const {
  const std::vector<double>& costs = tables_[table]->costs();
  if (costs.empty()) return 0.0;
  std::size_t index = 0;
  for (int v : scope(table)) index = index * cardinality(v) + values[v];
  return costs[index];
}

std::vector<std::vector<int>> connected_components(const std::vector<const Table*>& tables) {
  const DiscreteGraph graph(tables);
  std::vector<std::vector<int>> components;
  components.reserve(graph.component_count());
  for (int c = 0; c < graph.component_count(); ++c) {
    components.emplace_back(graph.component_tables(c).begin(), graph.component_tables(c).end());
  }
  return components;
}

}  // namespace hybrid
