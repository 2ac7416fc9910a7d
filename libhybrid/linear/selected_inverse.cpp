// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, the hybrid mapping authors
#include "libhybrid/linear/selected_inverse.h"

#include <algorithm>
#include <string>

#include "libhybrid/core/error.h"
#include "libhybrid/linear/front_kernels.h"

namespace hybrid {

SelectedInverse::SelectedInverse(const BlockCholesky& factor, WorkerPool& pool)
    : factor_(&factor), panels_(factor.panels_size()), workspace_(factor.workspace_size()) {
  // The plan of the update matrices of the factorisation serves in reverse: from when the parent is
  // done to when the supernode is.
  Scratch scratch;
  const std::vector<int>& top = factor.top();
  for (auto s = top.rbegin(); s != top.rend(); ++s) invert(factor.supernode(*s), scratch);
  pool.run(static_cast<int>(factor.tasks().size()), [&](int t) {
    Scratch own;
    const std::vector<int>& task = factor.tasks()[t];
    for (auto s = task.rbegin(); s != task.rend(); ++s) invert(factor.supernode(*s), own);
  });
}

void SelectedInverse::invert(const Supernode& node, Scratch& scratch) {
  invert_columns(node, scratch);
  for (int c = node.child_begin; c < node.child_end; ++c) {
    hand_down(factor_->supernode(factor_->children()[c]), node);
  }
}

/// With the panel (L11; L21), B = L21 L11^-1 and the inverse Z22 of the rows below:
/// Z21 = -Z22 B and Z11 = (L11 L11')^-1 - B' Z21.
void SelectedInverse::invert_columns(const Supernode& node, Scratch& scratch) {
  const int k = node.columns;
  const int m = node.below();
  const int wide = front::round_up(k);
  const int tall = front::round_up(m);
  const double* l = factor_->panel(node);
  const auto entry = [&](int row, int col) { return l[std::ptrdiff_t(col) * node.stride + row]; };

  // L11^-1, column by column; lower triangular.
  std::vector<double>& inverse = scratch.inverse;
  inverse.assign(std::size_t(wide) * wide, 0.0);
  for (int j = 0; j < k; ++j) {
    double* column = inverse.data() + std::size_t(j) * wide;
    column[j] = 1.0;
    for (int i = j; i < k; ++i) {
      column[i] /= entry(i, i);
      front::add_scaled(-column[i], &l[std::ptrdiff_t(i) * node.stride + i + 1], column + i + 1,
                        k - i - 1);
    }
  }
  // B' (k x m) = L11^-T L21': entry (c, r) sums the inverse's column c against row r.
  std::vector<double>& gain = scratch.gain;
  gain.assign(std::size_t(wide) * (tall + 1), 0.0);
  for (int r = 0; r < m; ++r) {
    double* out = gain.data() + std::size_t(r) * wide;
    for (int c = 0; c < k; ++c) {
      double sum = 0.0;
      for (int d = c; d < k; ++d) sum += inverse[std::size_t(c) * wide + d] * entry(k + r, d);
      out[c] = sum;
    }
  }
  std::vector<double>& coupling = scratch.coupling;
  coupling.assign(std::size_t(wide) * (tall + 1), 0.0);
  const double* below = workspace_.data() + node.update;
  front::product(gain.data(), wide, below, tall, m, -1.0, coupling.data(), wide, wide, tall);
  std::vector<double>& own = scratch.own;
  own.assign(std::size_t(wide) * wide, 0.0);
  front::product(gain.data(), wide, coupling.data(), wide, m, -1.0, own.data(), wide, wide, wide);

  double* z = panels_.data() + node.panel;
  for (int c = 0; c < k; ++c) {
    double* column = z + std::ptrdiff_t(c) * node.stride;
    for (int r = c; r < k; ++r) {
      column[r] =
          own[std::size_t(c) * wide + r] + front::dot(&inverse[std::size_t(c) * wide + r],
                                                      &inverse[std::size_t(r) * wide + r], k - r);
    }
    for (int r = 0; r < m; ++r) column[k + r] = coupling[std::size_t(r) * wide + c];
  }
}

/// Copies the inverse of the child's rows from the parent's front, and mirrors it.
void SelectedInverse::hand_down(const Supernode& child, const Supernode& parent) {
  const int size = front::round_up(child.below());
  const int parent_size = front::round_up(parent.below());
  double* target = workspace_.data() + child.update;
  std::fill_n(target, std::size_t(size) * size, 0.0);
  for (int a = child.run_begin; a < child.run_end; ++a) {
    const BlockCholesky::Run& across = factor_->runs()[a];
    for (int k = 0; k < across.length; ++k) {
      const int col = across.to + k;
      const double* from = col < parent.columns
                               ? panels_.data() + parent.panel + std::size_t(col) * parent.stride
                               : workspace_.data() + parent.update +
                                     std::size_t(col - parent.columns) * parent_size -
                                     parent.columns;
      double* to = target + std::size_t(across.from + k) * size;
      std::copy(from + col, from + across.to + across.length, to + across.from + k);
      for (int d = a + 1; d < child.run_end; ++d) {
        const BlockCholesky::Run& down = factor_->runs()[d];
        std::copy_n(from + down.to, down.length, to + down.from);
      }
    }
  }
  for (int c = 0; c < child.below(); ++c) {
    for (int r = c + 1; r < child.below(); ++r) {
      target[std::size_t(r) * size + c] = target[std::size_t(c) * size + r];
    }
  }
}

Eigen::MatrixXd SelectedInverse::diagonal_block(int start, int dim) const {
  const Supernode& node = factor_->supernode(factor_->supernode_of(start));
  Eigen::MatrixXd block(dim, dim);
  for (int c = 0; c < dim; ++c) {
    const int local = start - node.first;
    const double* column = panels_.data() + node.panel + std::size_t(local + c) * node.stride;
    for (int r = c; r < dim; ++r) block(r, c) = block(c, r) = column[local + r];
  }
  return block;
}

Eigen::MatrixXd SelectedInverse::block(int row, int rows, int col, int cols) const {
  if (row < col) return block(col, cols, row, rows).transpose();
  if (row == col) return diagonal_block(row, rows);
  const Supernode& node = factor_->supernode(factor_->supernode_of(col));
  const int* begin = factor_->rows(node);
  const int* at = std::lower_bound(begin, begin + node.height, row);
  if (at == begin + node.height || *at != row) {
    throw Error("the factor holds no block at row " + std::to_string(row) + ", column " +
                std::to_string(col));
  }
  const double* entry =
      panels_.data() + node.panel + std::size_t(col - node.first) * node.stride + (at - begin);
  return Eigen::Map<const Eigen::MatrixXd, 0, Eigen::OuterStride<>>(
      entry, rows, cols, Eigen::OuterStride<>(node.stride));
}

}  // namespace hybrid
