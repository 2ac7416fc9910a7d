// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, the hybrid mapping authors
#include "libhybrid/linear/sparsity.h"

#include <algorithm>
#include <iterator>
#include <map>
#include <string>

#include "libhybrid/core/error.h"
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

std::vector<std::vector<int>> neighbours_of(const BlockPattern& pattern) {
  std::vector<std::vector<int>> neighbours(pattern.size());
  for (const auto& [i, j] : pattern.edges) {
    neighbours[i].push_back(j);
    neighbours[j].push_back(i);
  }
  return neighbours;
}

std::vector<int> positions(const std::vector<int>& order, int size) {
  std::vector<int> position(size, -1);
  for (std::size_t k = 0; k < order.size(); ++k) {
    if (order[k] < 0 || order[k] >= size || position[order[k]] >= 0) {
      throw Error("elimination order: entry " + std::to_string(k) + " is " +
                  std::to_string(order[k]) + ", which is no block or comes twice");
    }
    position[order[k]] = static_cast<int>(k);
  }
  if (static_cast<int>(order.size()) != size) {
    throw Error("elimination order: names " + std::to_string(order.size()) + " of " +
                std::to_string(size) + " blocks");
  }
  return position;
}

/// Marks the removed blocks connected to `start` as seen and returns their remaining neighbours,
/// sorted.
std::vector<int> rim_of(int start, const std::vector<std::vector<int>>& neighbours,
                        const std::vector<char>& removed, std::vector<char>& seen) {
  std::vector<int> rim;
  std::vector<int> stack = {start};
  seen[start] = 1;
  while (!stack.empty()) {
    const int block = stack.back();
    stack.pop_back();
    for (int next : neighbours[block]) {
      if (!removed[next]) {
        rim.push_back(next);
      } else if (!seen[next]) {
        seen[next] = 1;
        stack.push_back(next);
      }
    }
  }
  sort_unique(rim);
  return rim;
}

}  // namespace

bool JacobianPattern::contains(Key key) const {
  return std::binary_search(variables.begin(), variables.end(), key);
}

int JacobianPattern::index(Key key) const {
  const auto it = std::lower_bound(variables.begin(), variables.end(), key);
  if (it == variables.end() || *it != key) throw Error("no factor touches " + to_string(key));
  return static_cast<int>(it - variables.begin());
}

JacobianPattern jacobian_pattern(const HybridGraph& graph, const Assignment& assignment) {
  JacobianPattern result;
  std::map<Key, int> dims;
  for_each_factor(graph, assignment, [&](const ContinuousFactor& factor) {
    for (std::size_t k = 0; k < factor.keys().size(); ++k) {
      dims.emplace(factor.keys()[k], factor.types()[k].dim);
    }
  });
  for (const auto& [key, dim] : dims) {
    result.variables.push_back(key);
    result.dims.push_back(dim);
  }
  for_each_factor(graph, assignment, [&](const ContinuousFactor& factor) {
    std::vector<int>& row = result.factors.emplace_back();
    for (Key key : factor.keys()) row.push_back(result.index(key));
  });
  return result;
}

Blocks jacobian_blocks(const JacobianPattern& jacobian) {
  Blocks blocks;
  for (std::size_t row = 0; row < jacobian.factors.size(); ++row) {
    for (int column : jacobian.factors[row]) blocks.emplace_back(static_cast<int>(row), column);
  }
  sort_unique(blocks);
  return blocks;
}

BlockPattern information_pattern(const JacobianPattern& jacobian) {
  BlockPattern pattern;
  pattern.dims = jacobian.dims;
  for (const auto& row : jacobian.factors) {
    for (int i : row) {
      for (int j : row) {
        if (i < j) pattern.edges.emplace_back(i, j);
      }
    }
  }
  sort_unique(pattern.edges);
  return pattern;
}

// Below its diagonal, a column of the factor has the rows of the matrix and those of its children
// in the elimination tree; its parent is the first of these rows.
FilledPattern cholesky_pattern(const BlockPattern& pattern, const std::vector<int>& order) {
  const std::vector<int> position = positions(order, pattern.size());
  const auto neighbours = neighbours_of(pattern);
  FilledPattern result;
  std::vector<std::vector<int>> handed(pattern.size());  // rows from the children, with repetitions
  std::vector<int> own;
  for (int column = 0; column < pattern.size(); ++column) {
    own.clear();
    for (int block : neighbours[order[column]]) {
      if (position[block] > column) own.push_back(position[block]);
    }
    std::sort(own.begin(), own.end());
    std::vector<int>& rows = handed[column];
    sort_unique(rows);
    std::vector<int> fresh;
    std::set_difference(rows.begin(), rows.end(), own.begin(), own.end(),
                        std::back_inserter(fresh));
    result.original.emplace_back(column, column);
    for (int row : own) result.original.emplace_back(row, column);
    for (int row : fresh) result.fill.emplace_back(row, column);
    std::vector<int> all;
    std::merge(own.begin(), own.end(), fresh.begin(), fresh.end(), std::back_inserter(all));
    if (all.size() > 1) {
      handed[all[0]].insert(handed[all[0]].end(), all.begin() + 1, all.end());
    }
    rows = {};
  }
  std::sort(result.original.begin(), result.original.end());
  std::sort(result.fill.begin(), result.fill.end());
  return result;
}

std::vector<std::vector<int>> marginal_cliques(const BlockPattern& pattern,
                                               const std::vector<char>& removed) {
  const auto neighbours = neighbours_of(pattern);
  std::vector<std::vector<int>> cliques;
  std::vector<char> seen(pattern.size(), 0);
  for (int b = 0; b < pattern.size(); ++b) {
    if (removed[b] && !seen[b]) cliques.push_back(rim_of(b, neighbours, removed, seen));
  }
  return cliques;
}

FilledPattern marginalized_pattern(const BlockPattern& pattern, const std::vector<char>& removed) {
  std::vector<int> number(pattern.size(), -1);
  int count = 0;
  for (int b = 0; b < pattern.size(); ++b) {
    if (!removed[b]) number[b] = count++;
  }
  FilledPattern result;
  for (int b = 0; b < count; ++b) result.original.emplace_back(b, b);
  for (const auto& [i, j] : pattern.edges) {
    if (!removed[i] && !removed[j]) result.original.emplace_back(number[j], number[i]);
  }
  std::sort(result.original.begin(), result.original.end());
  Blocks coupled;
  for (const std::vector<int>& clique : marginal_cliques(pattern, removed)) {
    for (std::size_t i = 0; i < clique.size(); ++i) {
      for (std::size_t j = 0; j < i; ++j)
        coupled.emplace_back(number[clique[i]], number[clique[j]]);
    }
  }
  sort_unique(coupled);
  std::set_difference(coupled.begin(), coupled.end(), result.original.begin(),
                      result.original.end(), std::back_inserter(result.fill));
  return result;
}

}  // namespace hybrid
