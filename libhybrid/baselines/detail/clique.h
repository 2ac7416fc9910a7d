// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, the hybrid mapping authors
#pragma once

#include <cstdint>
#include <vector>

namespace hybrid {

/// An undirected graph as rows of bits.
class Adjacency {
 public:
  explicit Adjacency(int size) : size_(size), words_((size + 63) / 64), bits_(size * words_, 0) {}
  int size() const { return size_; }
  std::size_t words() const { return words_; }
  /// Joins two different vertices.
  void join(int a, int b) {
    set(a, b);
    set(b, a);
  }
  bool joined(int a, int b) const { return (row(a)[b / 64] >> (b % 64) & 1) != 0; }
  const std::uint64_t* row(int a) const { return bits_.data() + a * words_; }
  int degree(int a) const;

 private:
  void set(int a, int b) { bits_[a * words_ + b / 64] |= std::uint64_t(1) << (b % 64); }

  int size_;
  std::size_t words_;
  std::vector<std::uint64_t> bits_;
};

struct Clique {
  std::vector<int> vertices;  ///< ascending
  bool exact = true;          ///< false if the search met its limit: a larger one may exist
  long nodes = 0;             ///< visited by the search
};

/// The largest set of vertices that are all joined: a greedy search from some vertices of largest
/// degree first, then branch and bound with colours as bound (Tomita and Kameda, 2007) until the
/// result is proven or `max_nodes` are visited. Zero nodes: greedy only.
Clique largest_clique(const Adjacency& graph, long max_nodes);

}  // namespace hybrid
