// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, the hybrid mapping authors
#include "libhybrid/linear/elimination.h"

#include <ccolamd.h>

#include <algorithm>
#include <new>
#include <numeric>

#include "libhybrid/core/error.h"

namespace hybrid {
namespace {

constexpr int kMergeDim = 12;         // cliques that eliminate fewer dimensions merge freely
constexpr double kMergeZeros = 0.15;  // else at most this share of new zeros in the merged columns

/// Columns of the elimination tree: structure of each variable and the edges assembled there.
struct Columns {
  std::vector<std::vector<int>> structure;  // positions above the column's own, ascending
  std::vector<std::vector<int>> edges;
  std::vector<int> parent;
};

Columns eliminate_columns(const Hypergraph& graph, const std::vector<int>& position) {
  const int n = graph.count;
  Columns columns;
  columns.structure.resize(n);
  columns.edges.resize(n);
  columns.parent.assign(n, -1);
  for (int e = 0; e < graph.edges(); ++e) {
    int first = n;
    for (int m = graph.edge_begin[e]; m < graph.edge_begin[e + 1]; ++m) {
      first = std::min(first, position[graph.members[m]]);
    }
    if (first < n) columns.edges[first].push_back(e);
  }
  std::vector<int> mark(n, -1);
  std::vector<int> child_head(n, -1), child_next(n, -1);
  for (int j = 0; j < n; ++j) {
    std::vector<int>& structure = columns.structure[j];
    mark[j] = j;
    const auto add = [&](int p) {
      if (mark[p] == j) return;
      mark[p] = j;
      structure.push_back(p);
    };
    for (int e : columns.edges[j]) {
      for (int m = graph.edge_begin[e]; m < graph.edge_begin[e + 1]; ++m) {
        add(position[graph.members[m]]);
      }
    }
    for (int c = child_head[j]; c >= 0; c = child_next[c]) {
      for (int p : columns.structure[c]) add(p);
    }
    if (structure.empty()) continue;
    std::sort(structure.begin(), structure.end());
    const int parent = structure.front();
    columns.parent[j] = parent;
    child_next[j] = child_head[parent];
    child_head[parent] = j;
  }
  return columns;
}

/// Merges columns into cliques: clique_of[j] is the last column of the clique that column j belongs
/// to.
std::vector<int> merge_columns(const Columns& columns, const std::vector<int>& dims) {
  const int n = static_cast<int>(columns.parent.size());
  std::vector<int> frontal(dims);  // dimensions eliminated by the clique whose last column is j
  std::vector<int> separator(n);   // dimensions left by it
  std::vector<long> zeros(n, 0);
  for (int j = 0; j < n; ++j) {
    separator[j] = 0;
    for (int p : columns.structure[j]) separator[j] += dims[p];
  }
  std::vector<int> merged_into(n, -1);
  for (int j = 0; j < n; ++j) {
    const int p = columns.parent[j];
    if (p < 0) continue;
    // A merge gives j's columns the rows of its parent's clique, with the frontals merged into that
    // so far; children of a parent come in ascending order.
    const long grown = frontal[p] + separator[p];
    const long extra = static_cast<long>(frontal[j]) * (grown - separator[j]);
    const long total = zeros[j] + zeros[p] + extra;
    const long rows = frontal[j] + grown;
    const long area = (frontal[j] + static_cast<long>(frontal[p])) * rows;
    const bool merge = extra == 0 || (frontal[j] + frontal[p] <= kMergeDim && total < area / 2) ||
                       static_cast<double>(total) < kMergeZeros * static_cast<double>(area);
    if (!merge) continue;
    merged_into[j] = p;
    frontal[p] += frontal[j];
    zeros[p] = total;
  }
  std::vector<int> clique_of(n);
  for (int j = n - 1; j >= 0; --j) {
    clique_of[j] = merged_into[j] < 0 ? j : clique_of[merged_into[j]];
  }
  return clique_of;
}

}  // namespace

std::vector<int> constrained_order(const Hypergraph& graph, const std::vector<int>& group) {
  const int n = graph.count;
  std::vector<int> order(n);
  std::iota(order.begin(), order.end(), 0);
  if (n < 3) {
    std::stable_sort(order.begin(), order.end(), [&](int a, int b) { return group[a] < group[b]; });
    return order;
  }
  // CCOLAMD takes the incidence matrix by columns: for each variable, the edges (rows) that hold
  // it.
  const int entries = static_cast<int>(graph.members.size());
  std::vector<int> begin(n + 1, 0);
  for (int v : graph.members) ++begin[v + 1];
  for (int v = 0; v < n; ++v) begin[v + 1] += begin[v];
  const std::size_t length = ccolamd_recommended(entries, graph.edges(), n);
  std::vector<int> rows(length);
  std::vector<int> next(begin.begin(), begin.end() - 1);
  for (int e = 0; e < graph.edges(); ++e) {
    for (int m = graph.edge_begin[e]; m < graph.edge_begin[e + 1]; ++m) {
      rows[next[graph.members[m]]++] = e;
    }
  }
  double knobs[CCOLAMD_KNOBS];
  int stats[CCOLAMD_STATS];
  ccolamd_set_defaults(knobs);
  knobs[CCOLAMD_DENSE_ROW] = -1;  // every row and column takes part
  knobs[CCOLAMD_DENSE_COL] = -1;
  std::vector<int> members(group);
  if (ccolamd(graph.edges(), n, static_cast<int>(length), rows.data(), begin.data(), knobs, stats,
              members.data()) == 0) {
    if (stats[CCOLAMD_STATUS] == CCOLAMD_ERROR_out_of_memory) throw std::bad_alloc();
    throw Error("ordering failed: CCOLAMD status " + std::to_string(stats[CCOLAMD_STATUS]));
  }
  std::copy(begin.begin(), begin.begin() + n, order.begin());
  return order;
}

std::vector<SymbolicClique> eliminate_symbolically(const Hypergraph& graph,
                                                   const std::vector<int>& order) {
  const int n = graph.count;
  std::vector<int> position(n), dims(n);
  for (int k = 0; k < n; ++k) {
    position[order[k]] = k;
    dims[k] = graph.dims[order[k]];
  }
  Columns columns = eliminate_columns(graph, position);
  const std::vector<int> clique_of = merge_columns(columns, dims);
  std::vector<int> index(n, -1);
  std::vector<SymbolicClique> cliques;
  for (int j = 0; j < n; ++j) {
    if (clique_of[j] != j) continue;
    index[j] = static_cast<int>(cliques.size());
    cliques.emplace_back();
    for (int p : columns.structure[j]) cliques.back().separators.push_back(order[p]);
  }
  for (int j = 0; j < n; ++j) {
    SymbolicClique& clique = cliques[index[clique_of[j]]];
    clique.frontals.push_back(order[j]);
    clique.edges.insert(clique.edges.end(), columns.edges[j].begin(), columns.edges[j].end());
    if (clique_of[j] == j && columns.parent[j] >= 0) {
      clique.parent = index[clique_of[columns.parent[j]]];
    }
  }
  return cliques;
}

}  // namespace hybrid
