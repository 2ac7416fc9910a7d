// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, the hybrid mapping authors
#include "libhybrid/hybrid/graph.h"

#include <string>
#include <unordered_map>
#include <utility>

namespace hybrid {

Handle HybridGraph::add(ContinuousFactorPtr factor) {
  if (factor == nullptr) throw Error("a null factor was added to a graph");
  return continuous_.add(std::move(factor));
}

Handle HybridGraph::add(Table table) {
  return discrete_.add(std::move(table));
}

Handle HybridGraph::add(HybridFactorPtr factor) {
  if (factor == nullptr) throw Error("a null factor was added to a graph");
  return hybrid_.add(std::move(factor));
}

HybridGraph::Removed HybridGraph::remove(Handle handle) {
  Removed removed{handle};
  switch (handle.kind) {
    case FactorKind::kContinuous:
      removed.continuous = continuous_.remove(handle);
      break;
    case FactorKind::kDiscrete:
      removed.discrete = discrete_.remove(handle);
      break;
    case FactorKind::kHybrid:
      removed.hybrid = hybrid_.remove(handle);
  }
  return removed;
}

void HybridGraph::put_back(Removed removed) {
  switch (removed.handle.kind) {
    case FactorKind::kContinuous:
      return continuous_.put_back(removed.handle, std::move(removed.continuous));
    case FactorKind::kDiscrete:
      return discrete_.put_back(removed.handle, std::move(removed.discrete));
    case FactorKind::kHybrid:
      return hybrid_.put_back(removed.handle, std::move(removed.hybrid));
  }
}

bool HybridGraph::contains(Handle handle) const {
  return continuous_.contains(handle) || discrete_.contains(handle) || hybrid_.contains(handle);
}

std::vector<DiscreteKey> HybridGraph::discrete_keys() const {
  std::vector<DiscreteKey> keys;
  std::unordered_map<Key, int> cardinality;
  const auto visit = [&](const std::vector<DiscreteKey>& some) {
    for (const DiscreteKey& key : some) {
      const auto [it, is_new] = cardinality.emplace(key.key, key.cardinality);
      if (is_new) keys.push_back(key);
      if (it->second != key.cardinality) {
        throw Error("discrete variable " + to_string(key.key) + " has " +
                    std::to_string(it->second) + " values in one factor and " +
                    std::to_string(key.cardinality) + " in another");
      }
    }
  };
  discrete_.for_each([&](Handle, const Table& table) { visit(table.keys()); });
  hybrid_.for_each([&](Handle, const HybridFactorPtr& factor) { visit(factor->discrete_keys()); });
  return keys;
}

double objective(const HybridGraph& graph, const Values& values, const Assignment& assignment) {
  double sum = 0.0;
  graph.continuous().for_each([&](Handle, const ContinuousFactorPtr& factor) {
    sum += factor->cost(values) + factor->log_normalizer();
  });
  graph.discrete().for_each([&](Handle, const Table& table) { sum += table.cost(assignment); });
  graph.hybrid().for_each(
      [&](Handle, const HybridFactorPtr& factor) { sum += factor->cost(values, assignment); });
  return sum;
}

double cost(const HybridGraph& graph, const Values& values, const Assignment& assignment) {
  double sum = 0.0;
  graph.continuous().for_each(
      [&](Handle, const ContinuousFactorPtr& factor) { sum += factor->cost(values); });
  graph.hybrid().for_each([&](Handle, const HybridFactorPtr& factor) {
    const Component component = factor->given(assignment);
    if (component.factor != nullptr) sum += component.factor->cost(values);
  });
  return sum;
}

}  // namespace hybrid
