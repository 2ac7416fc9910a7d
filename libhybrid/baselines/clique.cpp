// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, the hybrid mapping authors
#include "libhybrid/baselines/detail/clique.h"

#include <algorithm>
#include <numeric>

namespace hybrid {
namespace {

using Bits = std::vector<std::uint64_t>;

int count(const std::uint64_t* bits, std::size_t words) {
  int sum = 0;
  for (std::size_t w = 0; w < words; ++w) sum += __builtin_popcountll(bits[w]);
  return sum;
}

/// Calls visit(vertex) for every bit that is set.
template <class Visit>
void for_each(const Bits& bits, const Visit& visit) {
  for (std::size_t w = 0; w < bits.size(); ++w) {
    for (std::uint64_t rest = bits[w]; rest != 0; rest &= rest - 1) {
      visit(static_cast<int>(64 * w) + __builtin_ctzll(rest));
    }
  }
}

Bits intersection(const Bits& a, const std::uint64_t* b) {
  Bits result(a.size());
  for (std::size_t w = 0; w < a.size(); ++w) result[w] = a[w] & b[w];
  return result;
}

class Search {
 public:
  Search(const Adjacency& graph, long max_nodes) : graph_(graph), max_nodes_(max_nodes) {}

  Clique run() {
    greedy();
    if (max_nodes_ > 0) {
      Bits all(graph_.words(), 0);
      for (int v = 0; v < graph_.size(); ++v) all[v / 64] |= std::uint64_t(1) << (v % 64);
      std::vector<int> chosen;
      expand(all, chosen);
    }
    Clique result;
    result.exact = max_nodes_ > 0 && nodes_ <= max_nodes_;
    result.nodes = nodes_;
    result.vertices = best_;
    std::sort(result.vertices.begin(), result.vertices.end());
    return result;
  }

 private:
  /// From each of the vertices of largest degree, adds the vertex that keeps most candidates, until
  /// none is left.
  void greedy() {
    std::vector<int> order(graph_.size());
    std::iota(order.begin(), order.end(), 0);
    std::stable_sort(order.begin(), order.end(),
                     [&](int a, int b) { return graph_.degree(a) > graph_.degree(b); });
    if (order.size() > kGreedyStarts) order.resize(kGreedyStarts);
    for (int start : order) {
      if (graph_.degree(start) < static_cast<int>(best_.size())) break;
      std::vector<int> clique = {start};
      Bits candidates(graph_.row(start), graph_.row(start) + graph_.words());
      while (true) {
        int next = -1, most = -1;
        for_each(candidates, [&](int v) {
          const Bits left = intersection(candidates, graph_.row(v));
          const int degree = count(left.data(), left.size());
          if (degree > most) {
            most = degree;
            next = v;
          }
        });
        if (next < 0) break;
        clique.push_back(next);
        candidates = intersection(candidates, graph_.row(next));
      }
      if (clique.size() > best_.size()) best_ = clique;
    }
  }

  /// Vertices in the order of their colours, and the number of colours up to each, a bound: a
  /// clique has one vertex per colour at most.
  void color(const Bits& candidates, std::vector<int>& order, std::vector<int>& bound) const {
    Bits left = candidates;
    int colors = 0;
    for (int remaining = count(left.data(), left.size()); remaining > 0;) {
      ++colors;
      Bits same = left;  // may still take this colour
      for (std::size_t w = 0; w < same.size(); ++w) {
        while (same[w] != 0) {
          const int v = static_cast<int>(64 * w) + __builtin_ctzll(same[w]);
          const std::uint64_t bit = std::uint64_t(1) << (v % 64);
          same[w] &= ~bit;
          left[w] &= ~bit;
          const std::uint64_t* row = graph_.row(v);
          for (std::size_t u = w; u < same.size(); ++u) same[u] &= ~row[u];
          order.push_back(v);
          bound.push_back(colors);
          --remaining;
        }
      }
    }
  }

  void expand(Bits candidates, std::vector<int>& chosen) {
    if (++nodes_ > max_nodes_) return;
    std::vector<int> order, bound;
    color(candidates, order, bound);
    for (std::size_t i = order.size(); i-- > 0;) {
      if (chosen.size() + bound[i] <= best_.size() || nodes_ > max_nodes_) return;
      const int v = order[i];
      chosen.push_back(v);
      const Bits next = intersection(candidates, graph_.row(v));
      if (count(next.data(), next.size()) > 0) {
        expand(next, chosen);
      } else if (chosen.size() > best_.size()) {
        best_ = chosen;
      }
      chosen.pop_back();
      candidates[v / 64] &= ~(std::uint64_t(1) << (v % 64));
    }
  }

  static constexpr std::size_t kGreedyStarts = 10;

  const Adjacency& graph_;
  long max_nodes_;
  long nodes_ = 0;
  std::vector<int> best_;
};

}  // namespace

int Adjacency::degree(int a) const {
  return count(row(a), words_);
}

Clique largest_clique(const Adjacency& graph, long max_nodes) {
  return Search(graph, max_nodes).run();
}

}  // namespace hybrid
