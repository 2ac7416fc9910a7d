// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, the hybrid mapping authors
#include "libhybrid/linear/tree/deferral.h"

#include <algorithm>
#include <cmath>
#include <vector>

#include "libhybrid/linear/kernels/kernels.h"
#include "libhybrid/linear/tree/covariances.h"

namespace hybrid {
namespace {

/// Rows [A b] with [A b]' [A b] the Hessian of a factor, but for a constant: a Cholesky
/// factorisation with pivots, the largest first, as far as they are more than rounding.
Eigen::MatrixXd rows_of(const double* packed, int order) {
  Eigen::MatrixXd H(order, order);
  for (int j = 0; j < order; ++j) {
    const double* column = packed_column(packed, order, j);
    for (int i = j; i < order; ++i) H(i, j) = H(j, i) = column[i];
  }
  const Eigen::VectorXd all = H.diagonal();
  Eigen::MatrixXd rows(order - 1, order);
  int count = 0;
  for (; count < order - 1; ++count) {
    int best = -1;
    for (int i = 0; i < order - 1; ++i) {
      const bool is_rounding = !(H(i, i) > kPivotShare * all[i]);
      if (!is_rounding && (best < 0 || H(i, i) > H(best, best))) best = i;
    }
    if (best < 0) break;
    rows.row(count) = H.row(best) / std::sqrt(H(best, best));
    H.noalias() -= rows.row(count).transpose() * rows.row(count);
    H.row(best).setZero();
    H.col(best).setZero();
  }
  return rows.topRows(count);
}

/// One attempt to take what is new into the solution.
class Deferral {
 public:
  Deferral(const TreeParts& tree, const Charts* charts, EliminationWorkspace& workspace)
      : tree_(tree),
        charts_(charts),
        workspace_(workspace),
        born_(tree.cliques.born()),
        leaves_(tree.cliques.leaves()),
        factors_(tree.pending.factors()) {
    for (int f : tree.system.changes(LinearSystem::kNewFactors)) {
      if (tree.system.factor(f).alive) waiting_.push_back(f);
    }
  }

  bool run() {
    if (!hang_leaves() ||
        !std::all_of(waiting_.begin(), waiting_.end(), [&](int f) { return add_rows(f); })) {
      undo();
      return false;
    }
    if (tree_.pending.factors() > factors_) tree_.pending.pull(tree_.cliques);
    tree_.system.note_eliminated();
    return true;
  }

 private:
  bool is_placed(int v) const { return tree_.system.clique_of(v) >= 0; }

  /// Hangs each new variable below the tree by one of its factors. Returns whether all hang.
  bool hang_leaves() {
    std::vector<int> left;
    for (int v : tree_.system.changes(LinearSystem::kNewVariables)) left.push_back(v);
    for (bool goes_on = true; goes_on && !left.empty();) {
      goes_on = false;
      for (std::size_t k = 0; k < waiting_.size(); ++k) {
        if (!hang_leaf(waiting_[k])) continue;
        waiting_.erase(waiting_.begin() + static_cast<std::ptrdiff_t>(k--));
        goes_on = true;
      }
      left.erase(std::remove_if(left.begin(), left.end(), [&](int v) { return is_placed(v); }),
                 left.end());
    }
    return left.empty();
  }

  /// Hangs the one new variable of a factor below the tree, if it has one and determines it.
  bool hang_leaf(int f) {
    const std::vector<int>& members = tree_.system.factor(f).variables;
    const auto is_new = [&](int v) { return !is_placed(v); };
    const auto at = std::find_if(members.begin(), members.end(), is_new);
    if (at == members.end() || members.size() < 2 ||
        std::find_if(at + 1, members.end(), is_new) != members.end())
      return false;
    const int leaf = eliminate_leaf(tree_, charts_, workspace_, *at, f);
    if (leaf < 0) return false;
    hung_.push_back({*at, f});
    const TreeClique& clique = tree_.cliques[leaf];
    tree_.pending.pay_for_leaf(2.0 * clique.order * clique.frontal_dim);
    return true;
  }

  /// Lets a factor between variables of the tree pull at their paths.
  bool add_rows(int f) {
    const LinearSystem::Factor& factor = tree_.system.factor(f);
    for (int v : factor.variables) {
      const bool may_move = tree_.cliques[tree_.system.clique_of(v)].free;
      if (charts_ != nullptr && may_move && charts_->is_held(v)) return false;
    }
    const Eigen::MatrixXd rows = rows_of(tree_.system.hessian(f), factor.order);
    if (!rows.allFinite()) return false;
    const auto A = rows.leftCols(factor.order - 1);
    const TreeCovariances covariances(tree_.system, tree_.cliques, tree_.pending, charts_);
    const PathRows Y = covariances.substitute(factor.variables, A);
    for (int c : Y.path) {
      const TreeClique& clique = tree_.cliques[c];
      tree_.pending.pay(double(clique.order) * clique.frontal_dim * double(rows.rows()));
    }
    Eigen::VectorXd c = rows.rightCols<1>();
    if (charts_ == nullptr) c += A * steps_of(factor.variables);
    c -= Y.z.transpose() * residuals(Y.path);
    if (!tree_.pending.add(f, Y, c, tree_.cliques)) return false;
    tree_.system.set_factor_clique(f, LinearSystem::kPending);
    return true;
  }

  Eigen::VectorXd steps_of(const std::vector<int>& variables) const {
    int dims = 0;
    for (int v : variables) dims += tree_.system.dim(v);
    Eigen::VectorXd steps(dims);
    tree_.system.copy_deltas(variables, 0, variables.size(), steps.data());
    return steps;
  }

  /// The rows y = R d + z of some cliques at the present estimate.
  Eigen::VectorXd residuals(const std::vector<int>& path) const {
    std::vector<double> y, steps;
    for (int c : path) {
      const TreeClique& clique = tree_.cliques[c];
      steps.resize(clique.order - 1);
      if (charts_ == nullptr) {
        tree_.system.copy_deltas(clique.variables, 0, clique.variables.size(), steps.data());
      } else {
        charts_->see(clique.variables, 0, clique.chart(), steps.data());
      }
      tree_.pending.pay(double(clique.order) * clique.frontal_dim);
      const auto dot = kernels().dot;
      for (int j = 0; j < clique.frontal_dim; ++j) {
        const double* column = clique.columns() + static_cast<std::ptrdiff_t>(j) * clique.order;
        const int below = clique.order - 1 - j;
        y.push_back(column[clique.order - 1] + dot(column + j, steps.data() + j, below));
      }
    }
    return Eigen::Map<const Eigen::VectorXd>(y.data(), static_cast<Eigen::Index>(y.size()));
  }

  void undo() {
    for (int f : waiting_) tree_.system.set_factor_clique(f, -1);
    for (const auto& [v, f] : hung_) {
      tree_.system.set_clique(v, -1);
      tree_.system.set_factor_clique(f, -1);
    }
    tree_.pending.truncate(factors_, tree_.cliques);
    tree_.cliques.cut_leaves(leaves_);
    tree_.cliques.refuse(born_);
  }

  const TreeParts tree_;
  const Charts* const charts_;
  EliminationWorkspace& workspace_;
  const std::size_t born_, leaves_;
  const int factors_;
  std::vector<int> waiting_;               // factors
  std::vector<std::pair<int, int>> hung_;  // variables, and the factors that they hang by
};

}  // namespace

bool defer(const TreeParts& tree, const Charts* charts, EliminationWorkspace& workspace) {
  return Deferral(tree, charts, workspace).run();
}

}  // namespace hybrid
