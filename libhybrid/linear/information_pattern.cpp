// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, the hybrid mapping authors
#include "libhybrid/linear/information_pattern.h"

#include <map>

#include "libhybrid/core/sort_unique.h"

namespace hybrid {
namespace {

/// Calls visit(factor) for every continuous factor and every chosen component that is not weak.
template <class Visit>
void for_each_factor(const HybridGraph& graph, const Assignment& assignment, const Visit& visit) {
  graph.continuous().for_each([&](Handle, const ContinuousFactorPtr& factor) { visit(*factor); });
  graph.hybrid().for_each([&](Handle, const HybridFactorPtr& factor) {
    const Component component = factor->given(assignment);
    if (component.factor != nullptr && !component.weak) visit(*component.factor);
  });
}

}  // namespace

BlockPattern information_pattern(const HybridGraph& graph, const Assignment& assignment) {
  BlockPattern pattern;
  std::map<Key, int> blocks;
  for_each_factor(graph, assignment, [&](const ContinuousFactor& factor) {
    for (std::size_t k = 0; k < factor.keys().size(); ++k) {
      blocks.emplace(factor.keys()[k], factor.types()[k].dim);
    }
  });
  for (auto& [key, block] : blocks) {
    pattern.dims.push_back(block);
    block = pattern.size() - 1;
  }
  for_each_factor(graph, assignment, [&](const ContinuousFactor& factor) {
    for (const Key& one : factor.keys()) {
      for (const Key& other : factor.keys()) {
        const int i = blocks.at(one), j = blocks.at(other);
        if (i < j) pattern.edges.emplace_back(i, j);
      }
    }
  });
  sort_unique(pattern.edges);
  return pattern;
}

}  // namespace hybrid
