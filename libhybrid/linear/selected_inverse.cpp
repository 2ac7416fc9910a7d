// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, the hybrid mapping authors
#include "libhybrid/linear/selected_inverse.h"

#include <algorithm>
#include <string>

#include "libhybrid/core/error.h"
#include "libhybrid/core/paced_task.h"
#include "libhybrid/linear/kernels/kernels.h"

namespace hybrid {

SelectedInverse::SelectedInverse(const BlockCholesky& factor, WorkerPool& pool)
    : factor_(&factor), panels_(factor.panels_size()), workspace_(factor.workspace_size()) {
  // The places of the update matrices of the factorisation serve in reverse: each is in use from
  // the inversion of the parent to that of the supernode.
  Scratch scratch;
  const std::vector<int>& top = factor.top();
  const auto work = [](const Supernode& node) {
    return 2.0 * double(node.columns) * node.height * node.height;
  };
  for (auto s = top.rbegin(); s != top.rend(); ++s) {
    invert(factor.supernode(*s), scratch);
    note_work(work(factor.supernode(*s)));
  }
  pool.run(static_cast<int>(factor.tasks().size()), [&](int t) {
    Scratch own;
    const std::vector<int>& task = factor.tasks()[t];
    for (auto s = task.rbegin(); s != task.rend(); ++s) invert(factor.supernode(*s), own);
  });
  for (const std::vector<int>& task : factor.tasks()) {
    for (int s : task) note_work(work(factor.supernode(s)));
  }
}

void SelectedInverse::invert(const Supernode& node, Scratch& scratch) {
  invert_columns(node, scratch);
  for (int c = node.child_begin; c < node.child_end; ++c) {
    hand_down(factor_->supernode(factor_->children()[c]), node);
  }
}

void SelectedInverse::invert_columns(const Supernode& node, Scratch& scratch) {
  const std::size_t wide = round_up(node.columns);
  const std::size_t tall = round_up(node.below());
  scratch.inverse.assign(wide * wide, 0.0);
  scratch.own.assign(wide * wide, 0.0);
  scratch.gain.assign(wide * (tall + 1), 0.0);
  scratch.coupling.assign(wide * (tall + 1), 0.0);
  kernels().invert_panel({factor_->panel(node), node.stride, node.columns, node.below(),
                          workspace_.data() + node.update, scratch.inverse.data(),
                          scratch.own.data(), scratch.gain.data(), scratch.coupling.data(),
                          panels_.data() + node.panel});
}

/// Copies the inverse of the child's rows from the parent's front, and mirrors it.
void SelectedInverse::hand_down(const Supernode& child, const Supernode& parent) {
  const int size = round_up(child.below());
  const int parent_size = round_up(parent.below());
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
