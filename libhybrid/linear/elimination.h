// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, the hybrid mapping authors
#pragma once

#include <vector>

#include "libhybrid/export.h"

namespace HYBRID_API hybrid {

/// A hypergraph over variables 0 .. count - 1, for ordering and symbolic elimination: an edge is
/// the set of variables of one factor or of one separator.
struct Hypergraph {
  int count = 0;
  std::vector<int> dims;              ///< by variable
  std::vector<int> edge_begin = {0};  ///< edge e is members[edge_begin[e] .. edge_begin[e + 1])
  std::vector<int> members;

  int edges() const { return static_cast<int>(edge_begin.size()) - 1; }
  void close_edge() { edge_begin.push_back(static_cast<int>(members.size())); }
  void clear() {
    count = 0;
    dims.clear();
    edge_begin.assign(1, 0);
    members.clear();
  }
};

/// Fill-reducing elimination order by constrained COLAMD: order[k] is the variable eliminated k-th.
/// Variables of a higher group come after those of a lower one; groups are 0, 1, ... without gaps.
std::vector<int> constrained_order(const Hypergraph& graph, const std::vector<int>& group);

/// One clique of the elimination: the variables it eliminates and the ones it leaves to its
/// ancestors, both in elimination order.
struct SymbolicClique {
  std::vector<int> frontals;
  std::vector<int> separators;
  std::vector<int> edges;  ///< edges of the hypergraph that are assembled here
  int parent = -1;         ///< index of the parent clique, always higher than its own
};

/// Cliques of the elimination of `graph` in the given order, children before parents. Small cliques
/// are merged into their parent if that costs few extra zeros.
std::vector<SymbolicClique> eliminate_symbolically(const Hypergraph& graph,
                                                   const std::vector<int>& order);

}  // namespace hybrid
