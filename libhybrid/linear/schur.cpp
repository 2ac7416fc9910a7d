// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, the hybrid mapping authors
#include "libhybrid/linear/schur.h"

#include <algorithm>
#include <cmath>
#include <numeric>
#include <utility>

#include "libhybrid/core/sort_unique.h"

namespace hybrid {
namespace {

constexpr int kLeavesPerTask = 256;
constexpr int kSchurColumnsPerTask = 4;
constexpr int kMaxLeafDim = 6;
/// The Schur complement pays from so many leaves on, and so many for each other block.
constexpr int kLeastLeaves = 500;
constexpr int kLeavesPerOther = 4;

/// Neighbours of each block.
struct Adjacency {
  explicit Adjacency(const BlockPattern& pattern) : begin(pattern.size() + 1, 0) {
    for (const auto& [a, b] : pattern.edges) {
      ++begin[a + 1];
      ++begin[b + 1];
    }
    std::partial_sum(begin.begin(), begin.end(), begin.begin());
    members.resize(begin.back());
    std::vector<int> next(begin.begin(), begin.end() - 1);
    for (const auto& [a, b] : pattern.edges) {
      members[next[a]++] = b;
      members[next[b]++] = a;
    }
  }
  int degree(int block) const { return begin[block + 1] - begin[block]; }
  template <class Visit>
  void visit(int block, const Visit& visit) const {
    for (int m = begin[block]; m < begin[block + 1]; ++m) visit(members[m]);
  }

  std::vector<int> begin, members;
};

/// target -= a b' for a of kRows and b of kColumns rows, both with kDepth columns.
template <int kRows, int kColumns, int kDepth>
void subtract(const double* a, const double* b, int between, double* target, int stride) {
  for (int c = 0; c < kColumns; ++c) {
    double sum[kRows];
    for (int r = 0; r < kRows; ++r) sum[r] = target[c * stride + r];
    for (int d = 0; d < kDepth; ++d) {
      const double scale = b[d * between + c];
      for (int r = 0; r < kRows; ++r) sum[r] -= a[d * between + r] * scale;
    }
    for (int r = 0; r < kRows; ++r) target[c * stride + r] = sum[r];
  }
}

/// The same at run-time sizes; `between` is the distance of the columns of a and b.
void subtract(const double* a, int rows, const double* b, int columns, int depth, int between,
              double* target, int stride) {
  if (rows == 6 && columns == 6 && depth == 3) {
    return subtract<6, 6, 3>(a, b, between, target, stride);
  }
  if (rows == 3 && columns == 3 && depth == 2) {
    return subtract<3, 3, 2>(a, b, between, target, stride);
  }
  for (int c = 0; c < columns; ++c) {
    for (int d = 0; d < depth; ++d) {
      const double scale = b[d * between + c];
      for (int r = 0; r < rows; ++r) target[c * stride + r] -= a[d * between + r] * scale;
    }
  }
}

}  // namespace

std::vector<int> independent_blocks(const BlockPattern& pattern) {
  const Adjacency adjacency(pattern);
  std::vector<int> by_degree(pattern.size());
  std::iota(by_degree.begin(), by_degree.end(), 0);
  std::stable_sort(by_degree.begin(), by_degree.end(),
                   [&](int a, int b) { return adjacency.degree(a) < adjacency.degree(b); });
  std::vector<bool> excluded(pattern.size(), false);
  std::vector<int> leaves;
  for (int block : by_degree) {
    if (excluded[block] || pattern.dims[block] > kMaxLeafDim) continue;
    leaves.push_back(block);
    adjacency.visit(block, [&](int other) { excluded[other] = true; });
  }
  std::sort(leaves.begin(), leaves.end());
  return leaves;
}

bool schur_pays(const BlockPattern& pattern, const std::vector<int>& leaves) {
  const int count = static_cast<int>(leaves.size());
  return count >= kLeastLeaves && count >= kLeavesPerOther * (pattern.size() - count);
}

SchurOrdering order_schur(const BlockPattern& pattern, const std::vector<int>& leaves) {
  const Adjacency adjacency(pattern);
  std::vector<bool> is_leaf(pattern.size(), false);
  for (int leaf : leaves) is_leaf[leaf] = true;
  std::vector<int> others, index(pattern.size(), -1);
  for (int block = 0; block < pattern.size(); ++block) {
    if (is_leaf[block]) continue;
    index[block] = static_cast<int>(others.size());
    others.push_back(block);
  }
  // Eliminating a leaf couples all its neighbours.
  BlockPattern coupled;
  std::vector<int> mark(others.size(), -1);
  for (int j = 0; j < static_cast<int>(others.size()); ++j) {
    coupled.dims.push_back(pattern.dims[others[j]]);
    const auto couple = [&](int block) {
      const int i = index[block];
      if (i <= j || mark[i] == j) return;
      mark[i] = j;
      coupled.edges.emplace_back(j, i);
    };
    adjacency.visit(others[j], [&](int block) {
      if (is_leaf[block]) {
        adjacency.visit(block, couple);
      } else {
        couple(block);
      }
    });
  }
  sort_unique(coupled.edges);
  if (pattern.anchor >= 0) coupled.anchor = index[pattern.anchor];

  SchurOrdering result;
  result.leaves = static_cast<int>(leaves.size());
  result.reduced_ordering = order_blocks(coupled);
  std::vector<int> position(others.size());
  for (std::size_t p = 0; p < others.size(); ++p)
    position[result.reduced_ordering.order[p]] = int(p);
  result.reduced.dims.resize(others.size());
  for (std::size_t b = 0; b < others.size(); ++b) {
    result.reduced.dims[position[b]] = coupled.dims[b];
  }
  for (const auto& [a, b] : coupled.edges) {
    result.reduced.edges.push_back(std::minmax(position[a], position[b]));
  }
  sort_unique(result.reduced.edges);

  // Leaves by the first block that they meet, so that neighbours in memory are used together.
  std::vector<std::pair<int, int>> first;
  for (int leaf : leaves) {
    int least = pattern.size();
    adjacency.visit(leaf, [&](int block) { least = std::min(least, position[index[block]]); });
    first.emplace_back(least, leaf);
  }
  std::sort(first.begin(), first.end());
  for (const auto& [least, leaf] : first) result.order.push_back(leaf);
  for (int b : result.reduced_ordering.order) result.order.push_back(others[b]);
  std::iota(result.reduced_ordering.order.begin(), result.reduced_ordering.order.end(), 0);
  return result;
}

SchurCholesky::SchurCholesky(const BlockMatrix& matrix, const SchurOrdering& ordering)
    : leaf_scalars_(ordering.leaves < matrix.size() ? matrix.start(ordering.leaves)
                                                    : matrix.scalars()),
      reduced_(ordering.reduced, ordering.reduced_ordering.order, BlockMatrix::Triangle::kLower),
      cholesky_(reduced_, ordering.reduced_ordering) {
  collect_leaves(matrix, ordering.leaves);
}

void SchurCholesky::collect_leaves(const BlockMatrix& matrix, int leaves) {
  std::size_t y = 0, factor = 0;
  incidence_begin_.assign(matrix.size() - leaves + 1, 0);
  for (int l = 0; l < leaves; ++l) {
    Leaf leaf;
    leaf.start = matrix.start(l);
    leaf.dim = matrix.dim(l);
    leaf.height = matrix.stride(l) - leaf.dim;
    leaf.place = matrix.block(matrix.diagonal(l)).offset;
    leaf.y = y;
    leaf.first = static_cast<int>(edges_.size());
    int offset = 0;
    for (int b = matrix.block_begin(l) + 1; b < matrix.block_begin(l + 1); ++b) {
      edges_.push_back({matrix.block(b).row - leaves, offset});
      ++incidence_begin_[edges_.back().row + 1];
      offset += matrix.dim(matrix.block(b).row);
    }
    leaf.last = static_cast<int>(edges_.size());
    y += std::size_t(leaf.height) * leaf.dim;
    factor = std::max(factor, std::size_t(kMaxLeafDim) * (leaf.start + leaf.dim));
    leaves_.push_back(leaf);
  }
  y_.assign(y, 0.0);
  factors_.assign(factor, 0.0);
  std::partial_sum(incidence_begin_.begin(), incidence_begin_.end(), incidence_begin_.begin());
  incidences_.resize(edges_.size());
  std::vector<int> next(incidence_begin_.begin(), incidence_begin_.end() - 1);
  for (int l = 0; l < leaves; ++l) {
    for (int e = leaves_[l].first; e < leaves_[l].last; ++e)
      incidences_[next[edges_[e].row]++] = {l, e};
  }
}

int SchurCholesky::eliminate(const Leaf& leaf, const BlockMatrix& matrix, const double* extra) {
  const int dim = leaf.dim, distance = leaf.height + dim;
  const double* columns = matrix.values().data() + leaf.place;
  double* L = factors_.data() + std::size_t(kMaxLeafDim) * leaf.start;
  double* Y = y_.data() + leaf.y;
  int failed = -1;
  for (int c = 0; c < dim; ++c) {
    const double* w = columns + std::size_t(c) * distance + dim;
    double* target = Y + std::size_t(c) * leaf.height;
    std::copy_n(w, leaf.height, target);
    for (int r = c; r < dim; ++r) {
      double sum = columns[std::size_t(c) * distance + r] + (r == c ? extra[leaf.start + c] : 0.0);
      for (int k = 0; k < c; ++k) sum -= L[k * dim + r] * L[k * dim + c];
      if (r == c && failed < 0 && (!(sum > 0.0) || !std::isfinite(sum))) failed = leaf.start + c;
      L[c * dim + r] = r == c ? std::sqrt(sum) : sum / L[c * dim + c];
    }
    for (int k = 0; k < c; ++k) {
      const double scale = L[k * dim + c];
      const double* before = Y + std::size_t(k) * leaf.height;
      for (int r = 0; r < leaf.height; ++r) target[r] -= before[r] * scale;
    }
    const double inverse = 1.0 / L[c * dim + c];
    for (int r = 0; r < leaf.height; ++r) target[r] *= inverse;
  }
  return failed;
}

void SchurCholesky::reduce_column(int col, const BlockMatrix& matrix, std::vector<int>& place) {
  const int leaves = leaf_count(), dim = reduced_.dim(col), stride = reduced_.stride(col);
  double* values = reduced_.values().data();
  std::fill_n(values + reduced_.block(reduced_.block_begin(col)).offset, std::size_t(stride) * dim,
              0.0);
  for (int b = reduced_.block_begin(col); b < reduced_.block_begin(col + 1); ++b)
    place[reduced_.block(b).row] = b;
  for (int b = matrix.block_begin(leaves + col); b < matrix.block_begin(leaves + col + 1); ++b) {
    const BlockMatrix::Block& from = matrix.block(b);
    const BlockMatrix::Block& to = reduced_.block(place[from.row - leaves]);
    for (int c = 0; c < dim; ++c) {
      std::copy_n(
          matrix.values().data() + from.offset + std::size_t(c) * matrix.stride(leaves + col),
          matrix.dim(from.row), values + to.offset + std::size_t(c) * stride);
    }
  }
  for (int k = incidence_begin_[col]; k < incidence_begin_[col + 1]; ++k) {
    const Leaf& leaf = leaves_[incidences_[k].leaf];
    const double* Y = y_.data() + leaf.y;
    const double* own = Y + edges_[incidences_[k].edge].offset;
    for (int e = incidences_[k].edge; e < leaf.last; ++e) {
      const int row = edges_[e].row;
      subtract(Y + edges_[e].offset, reduced_.dim(row), own, dim, leaf.dim, leaf.height,
               values + reduced_.block(place[row]).offset, stride);
    }
  }
}

int SchurCholesky::factorize(const BlockMatrix& matrix, const double* extra, WorkerPool& pool) {
  const int tasks = (leaf_count() + kLeavesPerTask - 1) / kLeavesPerTask;
  std::vector<int> failed(tasks, -1);
  pool.run(tasks, [&](int task) {
    const int end = std::min(leaf_count(), (task + 1) * kLeavesPerTask);
    for (int l = task * kLeavesPerTask; l < end; ++l) {
      const int scalar = eliminate(leaves_[l], matrix, extra);
      if (scalar >= 0 && failed[task] < 0) failed[task] = scalar;
    }
  });
  for (int scalar : failed) {
    if (scalar >= 0) return scalar;
  }
  const int columns = reduced_.size();
  pool.run((columns + kSchurColumnsPerTask - 1) / kSchurColumnsPerTask, [&](int task) {
    std::vector<int> place(columns, -1);
    const int end = std::min(columns, (task + 1) * kSchurColumnsPerTask);
    for (int col = task * kSchurColumnsPerTask; col < end; ++col) reduce_column(col, matrix, place);
  });
  const int scalar = cholesky_.factorize(reduced_, extra + leaf_scalars_, pool);
  return scalar < 0 ? -1 : leaf_scalars_ + scalar;
}

void SchurCholesky::solve(double* x) const {
  double* others = x + leaf_scalars_;
  for (const Leaf& leaf : leaves_) {
    const double* L = factors_.data() + std::size_t(kMaxLeafDim) * leaf.start;
    double* z = x + leaf.start;
    for (int c = 0; c < leaf.dim; ++c) {
      z[c] /= L[c * leaf.dim + c];
      for (int r = c + 1; r < leaf.dim; ++r) z[r] -= L[c * leaf.dim + r] * z[c];
    }
    for (int e = leaf.first; e < leaf.last; ++e) {
      double* target = others + reduced_.start(edges_[e].row);
      const double* Y = y_.data() + leaf.y + edges_[e].offset;
      const int rows = reduced_.dim(edges_[e].row);
      for (int c = 0; c < leaf.dim; ++c) {
        for (int r = 0; r < rows; ++r) target[r] -= Y[std::size_t(c) * leaf.height + r] * z[c];
      }
    }
  }
  cholesky_.solve(others);
  for (const Leaf& leaf : leaves_) {
    const double* L = factors_.data() + std::size_t(kMaxLeafDim) * leaf.start;
    double* z = x + leaf.start;
    for (int e = leaf.first; e < leaf.last; ++e) {
      const double* from = others + reduced_.start(edges_[e].row);
      const double* Y = y_.data() + leaf.y + edges_[e].offset;
      const int rows = reduced_.dim(edges_[e].row);
      for (int c = 0; c < leaf.dim; ++c) {
        double sum = 0.0;
        for (int r = 0; r < rows; ++r) sum += Y[std::size_t(c) * leaf.height + r] * from[r];
        z[c] -= sum;
      }
    }
    for (int c = leaf.dim - 1; c >= 0; --c) {
      for (int r = c + 1; r < leaf.dim; ++r) z[c] -= L[c * leaf.dim + r] * z[r];
      z[c] /= L[c * leaf.dim + c];
    }
  }
}

double SchurCholesky::diagonal(int scalar) const {
  if (scalar >= leaf_scalars_) return cholesky_.diagonal(scalar - leaf_scalars_);
  // The last leaf that starts at or before the scalar.
  const auto after = std::upper_bound(leaves_.begin(), leaves_.end(), scalar,
                                      [](int s, const Leaf& leaf) { return s < leaf.start; });
  const Leaf& leaf = *std::prev(after);
  const int c = scalar - leaf.start;
  return factors_[std::size_t(kMaxLeafDim) * leaf.start + c * leaf.dim + c];
}

}  // namespace hybrid
