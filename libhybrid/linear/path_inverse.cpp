// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, the hybrid mapping authors
#include "libhybrid/linear/path_inverse.h"

#include <utility>

#include "libhybrid/core/paced_task.h"
#include "libhybrid/linear/detail/substitute.h"

namespace hybrid {

const PathInverse::Path& PathInverse::path(int start, int dim) {
  const auto known = paths_.find(start);
  if (known != paths_.end()) return known->second;
  Path path;
  int rows = 0;
  for (int s = factor_->supernode_of(start); s >= 0; s = factor_->supernode(s).parent) {
    path.supernodes.push_back(s);
    rows += factor_->supernode(s).columns;
  }
  // L x = E for all columns at once; x is zero outside the path.
  path.y.resize(rows, dim);
  // Not resized: Eigen frees what there was before it allocates, and twice where that fails.
  if (scratch_.cols() != dim) scratch_ = RowMatrix(factor_->size(), dim);
  for (int s : path.supernodes) {
    const auto& node = factor_->supernode(s);
    scratch_.middleRows(node.first, node.columns).setZero();
  }
  scratch_.middleRows(start, dim).setIdentity();
  int row = 0;
  for (int s : path.supernodes) {
    const auto& node = factor_->supernode(s);
    Eigen::MatrixXd front = Eigen::MatrixXd::Zero(node.height, dim);
    front.topRows(node.columns) = scratch_.middleRows(node.first, node.columns);
    substitute_all(factor_->panel(node), node.stride, node.height, node.columns, front.data(), dim);
    path.y.middleRows(row, node.columns) = front.topRows(node.columns);
    const int* below = factor_->rows(node) + node.columns;
    for (int r = 0; r < node.below(); ++r) scratch_.row(below[r]) += front.row(node.columns + r);
    row += node.columns;
    note_work(double(node.height) * node.columns * dim);
  }
  return paths_.emplace(start, std::move(path)).first->second;
}

int PathInverse::shared_rows(int start_a, int start_b) const {
  const std::vector<int>& of_a = paths_.at(start_a).supernodes;
  const std::vector<int>& of_b = paths_.at(start_b).supernodes;
  int shared = 0;
  for (auto p = of_a.rbegin(), q = of_b.rbegin(); p != of_a.rend() && q != of_b.rend() && *p == *q;
       ++p, ++q) {
    shared += factor_->supernode(*p).columns;
  }
  return shared;
}

Eigen::MatrixXd PathInverse::block(int start_a, int dim_a, int start_b, int dim_b) {
  path(start_a, dim_a);
  const Eigen::MatrixXd& b = path(start_b, dim_b).y;
  const Eigen::MatrixXd& a = paths_.at(start_a).y;
  const int shared = shared_rows(start_a, start_b);
  return a.bottomRows(shared).transpose() * b.bottomRows(shared);
}

}  // namespace hybrid
