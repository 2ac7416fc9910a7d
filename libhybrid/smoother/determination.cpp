// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, the hybrid mapping authors
// Whether variables whose pivots are lost in rounding are determined all the same.
#include <Eigen/QR>
#include <algorithm>
#include <cmath>
#include <unordered_map>
#include <vector>

#include "libhybrid/smoother/incremental.h"
#include "libhybrid/solvers/null_space.h"

namespace hybrid {
namespace {

/// A direction in which the whitened residuals change by less than this, of what they would change
/// by if each saw it alone, is undetermined: far above rounding, far below what any measurement
/// says.
constexpr double kRankTolerance = 1e-10;
/// Dense systems up to this size are looked at by themselves.
constexpr int kSmall = 300;

}  // namespace

/// The whitened Jacobian of the tree's factors by the variables that are new, each scaled to unit
/// norm; a rank below the number of columns leaves them undetermined.
bool IncrementalSmoother::new_variables_are_determined(const std::vector<Key>& keys) const {
  std::unordered_map<int, int> column;
  int columns = 0;
  std::vector<int> terms;
  for (Key key : keys) {
    const int slot = theta_->slot(key);
    column[slot] = columns;
    columns += theta_->type(slot).dim;
    const std::vector<int>& own = terms_.of_variable(slot);
    terms.insert(terms.end(), own.begin(), own.end());
  }
  std::sort(terms.begin(), terms.end());
  terms.erase(std::unique(terms.begin(), terms.end()), terms.end());
  int rows = 0;
  for (int t : terms) rows += terms_[t].tree_factor < 0 ? 0 : terms_[t].component.factor->rows();
  if (columns == 0) return true;
  if (rows < columns) return false;
  Eigen::MatrixXd all = Eigen::MatrixXd::Zero(rows, columns);
  int row = 0;
  for (int t : terms) {
    if (terms_[t].tree_factor < 0) continue;
    const ContinuousFactor& factor = *terms_[t].component.factor;
    const std::vector<int> slots = active_slots(terms_[t]);
    std::vector<const double*> x;
    for (int slot : slots) x.push_back(theta_->data(slot));
    Eigen::VectorXd r(factor.rows());
    Eigen::MatrixXd J(factor.rows(), factor.cols());
    factor.linearize(x.data(), r.data(), J.data());
    int from = 0;
    for (std::size_t i = 0; i < slots.size(); ++i) {
      const int dim = factor.types()[i].dim;
      const auto to = column.find(slots[i]);
      if (to != column.end()) {
        all.block(row, to->second, factor.rows(), dim) += J.middleCols(from, dim);
      }
      from += dim;
    }
    row += factor.rows();
  }
  for (const auto& [slot, first] : column) {
    auto block = all.middleCols(first, theta_->type(slot).dim);
    const double norm = block.norm();
    if (!(norm > 0.0) || !std::isfinite(norm)) return false;
    block /= norm;
  }
  Eigen::ColPivHouseholderQR<Eigen::MatrixXd> qr(all);
  qr.setThreshold(kRankTolerance);
  return qr.rank() == columns;
}

/// Every state of the smoother is determined. So where nothing was lost since the last commit, all
/// is determined if the new variables are, given the others.
bool IncrementalSmoother::is_determined(const std::vector<int>& slots) const {
  for (int slot : slots) {
    const std::vector<int>& own = terms_.of_variable(slot);
    if (std::none_of(own.begin(), own.end(), [&](int t) { return terms_[t].tree_factor >= 0; }))
      return false;
  }
  int dims = 0;
  for (Key key : theta_.inserted()) dims += theta_->type(key).dim;
  if (!lost_factors_ && dims <= kSmall) return new_variables_are_determined(theta_.inserted());
  return free_variables(graph_, {theta_.get(), assignment()},
                        couple_weak_ ? WeakComponents::kCoupled : WeakComponents::kUncoupled)
      .empty();
}

}  // namespace hybrid
