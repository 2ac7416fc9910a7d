// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, the hybrid mapping authors
#include "libhybrid/marginals/detail/discrete_index.h"

namespace hybrid {

DiscreteIndex::DiscreteIndex(const HybridGraph& graph) {
  graph.discrete().for_each([&](Handle, const Table& table) {
    for (const DiscreteKey& key : table.keys()) entry(key).tables.push_back(&table);
  });
  graph.hybrid().for_each([&](Handle, const HybridFactorPtr& factor) {
    for (const DiscreteKey& key : factor->discrete_keys()) {
      entry(key).factors.push_back(factor.get());
    }
    for (const DiscreteKey& key : factor->selectors()) entry(key).selects = true;
  });
}

DiscreteIndex::Variable& DiscreteIndex::entry(DiscreteKey key) {
  Variable& variable = variables_[key.key];
  variable.key = key;
  return variable;
}

const DiscreteIndex::Variable& DiscreteIndex::at(Key key) const {
  const auto it = variables_.find(key);
  if (it == variables_.end())
    throw Error("discrete variable " + to_string(key) + " is in no factor");
  return it->second;
}

}  // namespace hybrid
