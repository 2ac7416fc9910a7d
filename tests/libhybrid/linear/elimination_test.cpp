// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, the hybrid mapping authors
#include "libhybrid/linear/elimination.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <set>

#include "tests/support/random.h"

namespace hybrid {
namespace {

using testing::Random;

Hypergraph random_hypergraph(int count, int edges, Random& random) {
  Hypergraph graph;
  graph.count = count;
  for (int v = 0; v < count; ++v) graph.dims.push_back(1 + random.below(6));
  for (int e = 0; e < edges; ++e) {
    std::set<int> members;
    const int size = 1 + random.below(4);
    for (int k = 0; k < size; ++k) members.insert(random.below(count));
    graph.members.insert(graph.members.end(), members.begin(), members.end());
    graph.close_edge();
  }
  return graph;
}

std::vector<int> random_groups(int count, Random& random) {
  std::vector<int> group(count, 0);
  for (int& g : group) g = random.below(5) == 0 ? 1 : 0;
  group[0] = 0;  // no gaps
  return group;
}

/// What must hold whatever is merged: every variable is eliminated once; edges and separators lie
/// within the cliques that take them up; parents come later.
void expect_valid(const Hypergraph& graph, const std::vector<int>& order,
                  const std::vector<SymbolicClique>& cliques) {
  std::vector<int> position(graph.count);
  for (int k = 0; k < graph.count; ++k) position[order[k]] = k;
  std::vector<int> eliminated(graph.count, 0);
  std::vector<int> assembled(graph.edges(), 0);
  for (std::size_t c = 0; c < cliques.size(); ++c) {
    const SymbolicClique& clique = cliques[c];
    ASSERT_FALSE(clique.frontals.empty());
    std::set<int> all(clique.frontals.begin(), clique.frontals.end());
    all.insert(clique.separators.begin(), clique.separators.end());
    EXPECT_EQ(all.size(), clique.frontals.size() + clique.separators.size());
    for (int v : clique.frontals) ++eliminated[v];
    for (int v : clique.separators) EXPECT_GT(position[v], position[clique.frontals.back()]);
    for (int e : clique.edges) {
      ++assembled[e];
      for (int m = graph.edge_begin[e]; m < graph.edge_begin[e + 1]; ++m) {
        EXPECT_TRUE(all.count(graph.members[m]));
      }
    }
    EXPECT_EQ(clique.parent < 0, clique.separators.empty());
    if (clique.parent < 0) continue;
    ASSERT_GT(clique.parent, static_cast<int>(c));
    const SymbolicClique& parent = cliques[clique.parent];
    std::set<int> above(parent.frontals.begin(), parent.frontals.end());
    EXPECT_TRUE(std::any_of(clique.separators.begin(), clique.separators.end(),
                            [&](int v) { return above.count(v) != 0; }));
    above.insert(parent.separators.begin(), parent.separators.end());
    for (int v : clique.separators) EXPECT_TRUE(above.count(v)) << "separator not in the parent";
  }
  EXPECT_EQ(std::count(eliminated.begin(), eliminated.end(), 1), graph.count);
  EXPECT_EQ(std::count(assembled.begin(), assembled.end(), 1), graph.edges());
}

TEST(Elimination, CliquesCoverRandomGraphs) {
  for (int seed = 1; seed <= 500; ++seed) {
    SCOPED_TRACE("seed " + std::to_string(seed));
    Random random(seed);
    const int count = 1 + random.below(40);
    const Hypergraph graph = random_hypergraph(count, random.below(80), random);
    const std::vector<int> group = random_groups(count, random);
    const std::vector<int> order = constrained_order(graph, group);
    std::vector<int> sorted = order;
    std::sort(sorted.begin(), sorted.end());
    for (int k = 0; k < count; ++k) ASSERT_EQ(sorted[k], k);
    for (int k = 1; k < count; ++k) EXPECT_LE(group[order[k - 1]], group[order[k]]);
    expect_valid(graph, order, eliminate_symbolically(graph, order));
  }
}

TEST(Elimination, AChainHasNoMoreFillThanItsEdges) {
  Hypergraph graph;
  graph.count = 1000;
  graph.dims.assign(graph.count, 20);  // too large to merge
  for (int v = 0; v + 1 < graph.count; ++v) {
    graph.members.push_back(v);
    graph.members.push_back(v + 1);
    graph.close_edge();
  }
  const std::vector<int> order = constrained_order(graph, std::vector<int>(graph.count, 0));
  for (const SymbolicClique& clique : eliminate_symbolically(graph, order)) {
    EXPECT_LE(clique.frontals.size() + clique.separators.size(), 3u);
  }
}

}  // namespace
}  // namespace hybrid
