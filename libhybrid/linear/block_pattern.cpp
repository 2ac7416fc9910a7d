// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, the hybrid mapping authors
#include "libhybrid/linear/block_pattern.h"

#include <cholmod.h>

#include <algorithm>
#include <new>
#include <numeric>
#include <optional>

#include "libhybrid/core/error.h"
#include "libhybrid/core/paced_task.h"

namespace hybrid {
namespace {

/// Below this many operations per block the search for a better order costs more than it saves.
constexpr double kDissectionFlopsPerBlock = 2e4;
/// A taller elimination tree, as minimum degree makes of a chain, costs covariances dearly.
constexpr int kTallTree = 200;

/// CHOLMOD's analysis of a graph by the method set in `common`; null where it fails.
cholmod_factor* analyze(cholmod_sparse& graph, int anchor, cholmod_common& common) {
  const int n = static_cast<int>(graph.nrow);
  if (anchor < 0 || n == 1) return cholmod_analyze(&graph, &common);  // CAMD asks for a group 0
  std::vector<int> order(n);
  if (common.method[0].ordering == CHOLMOD_AMD) {
    std::vector<int> group(n, 0);
    group[anchor] = 1;  // after group 0
    if (!cholmod_camd(&graph, nullptr, 0, group.data(), order.data(), &common)) return nullptr;
  } else {
    cholmod_factor* free = cholmod_analyze(&graph, &common);
    if (free == nullptr) return nullptr;
    const int* perm = static_cast<const int*>(free->Perm);
    std::remove_copy(perm, perm + n, order.begin(), anchor);
    order.back() = anchor;
    cholmod_free_factor(&free, &common);
  }
  common.method[0].ordering = CHOLMOD_GIVEN;
  return cholmod_analyze_p(&graph, order.data(), nullptr, 0, &common);
}

/// CHOLMOD's state and a factor, freed at the end.
struct Workspace {
  Workspace() { cholmod_start(&common); }
  ~Workspace() {
    cholmod_free_factor(&factor, &common);
    cholmod_finish(&common);
  }
  Workspace(const Workspace&) = delete;
  Workspace& operator=(const Workspace&) = delete;

  cholmod_common common{};
  cholmod_factor* factor = nullptr;
};

/// Orders the block graph with one of CHOLMOD's methods; nothing where it fails, as nested
/// dissection does in a CHOLMOD that was built without METIS. Throws std::bad_alloc.
std::optional<BlockOrdering> order_with(const BlockPattern& pattern, int method) {
  const int n = pattern.size();
  std::vector<int> start(n + 1, 0);
  std::vector<int> rows(pattern.edges.size() + n);
  for (const auto& edge : pattern.edges) ++start[edge.second + 1];
  for (int j = 0; j < n; ++j) start[j + 1] += start[j] + 1;
  std::vector<int> next(start.begin(), start.end() - 1);
  for (const auto& edge : pattern.edges) rows[next[edge.second]++] = edge.first;
  for (int j = 0; j < n; ++j) rows[next[j]] = j;

  cholmod_sparse graph{};
  graph.nrow = graph.ncol = n;
  graph.nzmax = rows.size();
  graph.p = start.data();
  graph.i = rows.data();
  graph.stype = 1;
  graph.itype = CHOLMOD_INT;
  graph.xtype = CHOLMOD_PATTERN;
  graph.dtype = CHOLMOD_DOUBLE;
  graph.sorted = graph.packed = 1;

  Workspace workspace;
  cholmod_common& common = workspace.common;
  common.print = 0;
  common.nmethods = 1;
  common.method[0].ordering = method;
  common.supernodal = CHOLMOD_SUPERNODAL;
  const cholmod_factor* factor = workspace.factor = analyze(graph, pattern.anchor, common);
  if (factor == nullptr && common.status == CHOLMOD_OUT_OF_MEMORY) throw std::bad_alloc();
  if (factor == nullptr) return std::nullopt;
  BlockOrdering result;
  const int* perm = static_cast<const int*>(factor->Perm);
  const int* counts = static_cast<const int*>(factor->ColCount);
  result.order.assign(perm, perm + n);
  const auto copy = [](const void* from, std::size_t size) {
    return std::vector<int>(static_cast<const int*>(from), static_cast<const int*>(from) + size);
  };
  result.supernodes = copy(factor->super, factor->nsuper + 1);
  result.row_starts = copy(factor->pi, factor->nsuper + 1);
  result.rows = copy(factor->s, result.row_starts.back());
  const double mean_dim = n == 0 ? 0.0 : double(pattern.scalars()) / n;
  for (int k = 0; k < n; ++k) {
    const int dim = pattern.dims[perm[k]];
    const double below = (counts[k] - 1) * mean_dim;
    for (int c = 0; c < dim; ++c) {
      const double rows_of_column = below + dim - c;
      result.nonzeros += rows_of_column;
      result.flops += rows_of_column * rows_of_column;
    }
  }
  return result;
}

/// Blocks on the longest path of the elimination tree.
int height(const BlockOrdering& ordering) {
  const int count = static_cast<int>(ordering.supernodes.size()) - 1;
  std::vector<int> supernode_of(ordering.order.size());
  for (int s = 0; s < count; ++s) {
    for (int p = ordering.supernodes[s]; p < ordering.supernodes[s + 1]; ++p) supernode_of[p] = s;
  }
  std::vector<int> heights(count);
  int highest = 0;
  for (int s = count - 1; s >= 0; --s) {  // a parent comes after its children
    const int own = ordering.supernodes[s + 1] - ordering.supernodes[s];
    const int below = ordering.row_starts[s] + own;
    heights[s] = own;
    if (below < ordering.row_starts[s + 1])
      heights[s] += heights[supernode_of[ordering.rows[below]]];
    highest = std::max(highest, heights[s]);
  }
  return highest;
}

/// Multiplications for each pair of blocks in the time that an ordering by degree, or by cuts,
/// takes, about.
constexpr double kWorkOfEdge = 1e3, kWorkOfCut = 1e4;

}  // namespace

int BlockPattern::scalars() const {
  return std::accumulate(dims.begin(), dims.end(), 0);
}

BlockOrdering order_blocks(const BlockPattern& pattern, Trees trees) {
  if (pattern.size() == 0) return {};
  std::optional<BlockOrdering> first = order_with(pattern, CHOLMOD_AMD);
  note_work(kWorkOfEdge * double(pattern.edges.size()));
  if (!first) {
    throw Error("ordering of a system of " + std::to_string(pattern.size()) + " variables failed");
  }
  BlockOrdering& best = *first;
  const bool tall = trees == Trees::kLow && height(best) > std::max(kTallTree, pattern.size() / 4);
  if (tall || best.flops > kDissectionFlopsPerBlock * pattern.size()) {
    std::optional<BlockOrdering> other = order_with(pattern, CHOLMOD_METIS);
    note_work(kWorkOfCut * double(pattern.edges.size()));
    if (other && (tall || other->flops < best.flops)) best = std::move(*other);
  }
  return std::move(best);
}

}  // namespace hybrid
