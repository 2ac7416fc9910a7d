// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, the hybrid mapping authors
#include "libhybrid/smoother/detail/determination.h"

#include <Eigen/QR>
#include <algorithm>
#include <cmath>
#include <unordered_map>
#include <unordered_set>
#include <utility>
#include <vector>

#include "libhybrid/core/sort_unique.h"
#include "libhybrid/solvers/null_space.h"

namespace hybrid {
namespace {

/// A direction in which the whitened residuals change by less than this, of what they would change
/// by if each saw it alone, is undetermined: far above rounding, far below what any measurement
/// says.
constexpr double kRankTolerance = 1e-10;
/// Dense systems up to this size are looked at by themselves.
constexpr int kSmall = 300;
constexpr int kNear = 60;  ///< which is tried first: it takes a fiftieth of the time
/// A row is a combination of others where all but this share of it is: the rank tolerance, with
/// room for the condition of what remains.
constexpr double kSameRow = 1e-7;

/// The whitened Jacobian of some factors by some variables, row after row; factors may hold other
/// variables too, whose columns are left out.
class LocalJacobian {
 public:
  LocalJacobian(const Values& values, const std::vector<int>& slots) : values_(values) {
    for (int slot : slots) {
      if (!column_.emplace(slot, columns_).second) continue;
      columns_ += values.type(slot).dim;
    }
  }

  int columns() const { return columns_; }
  bool contains(int slot) const { return column_.count(slot) != 0; }

  void append(const ContinuousFactor& factor, const std::vector<int>& slots) {
    std::vector<const double*> x;
    for (int slot : slots) x.push_back(values_.data(slot));
    Eigen::VectorXd r(factor.rows());
    Eigen::MatrixXd J(factor.rows(), factor.cols());
    factor.linearize(x.data(), r.data(), J.data());
    Eigen::MatrixXd rows = Eigen::MatrixXd::Zero(factor.rows(), columns_);
    int from = 0;
    for (std::size_t i = 0; i < slots.size(); ++i) {
      const int dim = factor.types()[i].dim;
      const auto to = column_.find(slots[i]);
      if (to != column_.end()) rows.middleCols(to->second, dim) += J.middleCols(from, dim);
      from += dim;
    }
    blocks_.push_back(std::move(rows));
    rows_ += factor.rows();
  }

  Eigen::MatrixXd matrix() const {
    Eigen::MatrixXd all(rows_, columns_);
    int row = 0;
    for (const Eigen::MatrixXd& block : blocks_) {
      all.middleRows(row, block.rows()) = block;
      row += static_cast<int>(block.rows());
    }
    return all;
  }

  /// The norm of each variable's columns, one number a column; zero where nothing moves with it.
  Eigen::VectorXd scales(const Eigen::MatrixXd& matrix) const {
    Eigen::VectorXd scale(columns_);
    for (const auto& [slot, first] : column_) {
      const int dim = values_.type(slot).dim;
      scale.segment(first, dim).setConstant(matrix.middleCols(first, dim).norm());
    }
    return scale;
  }

 private:
  const Values& values_;
  std::unordered_map<int, int> column_;
  std::vector<Eigen::MatrixXd> blocks_;
  int columns_ = 0, rows_ = 0;
};

/// What rows say of other variables once those of `out` are free: the combinations of `rows` in
/// which the columns of `out` cancel.
Eigen::MatrixXd without(const Eigen::MatrixXd& out, const Eigen::MatrixXd& rows) {
  if (out.cols() == 0) return rows;
  Eigen::ColPivHouseholderQR<Eigen::MatrixXd> qr(out);
  qr.setThreshold(kRankTolerance);
  const Eigen::MatrixXd turned = qr.householderQ().transpose() * rows;
  return turned.bottomRows(rows.rows() - qr.rank());
}

/// The whitened Jacobian of the tree's factors by the variables that are new, each scaled to unit
/// norm; a rank below the number of columns leaves them undetermined.
bool new_variables_are_determined(const Terms& terms, const JournaledValues& estimate) {
  std::vector<int> slots, near;
  for (Key key : estimate.inserted()) {
    slots.push_back(estimate->slot(key));
    const std::vector<int>& own = terms.of_variable(slots.back());
    near.insert(near.end(), own.begin(), own.end());
  }
  sort_unique(near);
  LocalJacobian local(estimate.get(), slots);
  for (int t : near) {
    if (terms[t].tree_factor < 0) continue;
    local.append(*terms[t].component.factor, active_slots(terms[t]));
  }
  if (local.columns() == 0) return true;
  Eigen::MatrixXd all = local.matrix();
  if (all.rows() < all.cols()) return false;
  const Eigen::VectorXd scale = local.scales(all);
  if (!(scale.minCoeff() > 0.0) || !scale.allFinite()) return false;
  all *= scale.cwiseInverse().asDiagonal();
  Eigen::ColPivHouseholderQR<Eigen::MatrixXd> qr(all);
  qr.setThreshold(kRankTolerance);
  return qr.rank() == local.columns();
}

/// Whether the factors of the tree about the variables of the factors that have left, the nearest
/// with about so many dimensions at most, say all that those said: their rows are combinations of
/// the rows that remain. Then what was determined still is. The answer does not depend on how far
/// away the rest of the graph is.
bool others_say_what_was_lost(const LinearModels& models, const JournaledValues& estimate,
                              int most_dims) {
  const Terms& terms = models.terms();
  const Values& values = estimate.get();
  std::vector<int> slots, removed, near;
  std::unordered_set<int> has_slot, has_term;
  int dims = 0;
  const auto take = [&](int slot) {
    if (!has_slot.insert(slot).second) return;
    slots.push_back(slot);
    dims += values.type(slot).dim;
  };
  for (const LinearModels::Lost& lost : models.lost()) {
    for (int slot : lost.slots) {
      if (estimate.is_removed(values.key(slot))) {
        removed.push_back(slot);
      } else {
        take(slot);
      }
    }
  }
  if (dims > most_dims) return false;
  for (std::size_t next = 0; next < slots.size(); ++next) {
    for (int t : terms.of_variable(slots[next])) {
      if (terms[t].tree_factor < 0 || !has_term.insert(t).second) continue;
      const std::vector<int> active = active_slots(terms[t]);
      if (dims < most_dims) std::for_each(active.begin(), active.end(), take);
      if (std::all_of(active.begin(), active.end(),
                      [&](int slot) { return has_slot.count(slot) != 0; })) {
        near.push_back(t);
      } else {
        has_term.erase(t);
      }
    }
  }
  LocalJacobian remaining(values, slots), gone(values, slots);
  LocalJacobian by_removed(values, removed);
  for (int t : near) remaining.append(*terms[t].component.factor, active_slots(terms[t]));
  for (const LinearModels::Lost& lost : models.lost()) {
    gone.append(*lost.factor, lost.slots);
    by_removed.append(*lost.factor, lost.slots);
  }
  if (remaining.columns() == 0) return true;  // all that was said was of variables that are gone
  Eigen::MatrixXd J = remaining.matrix();
  Eigen::MatrixXd L = without(by_removed.matrix(), gone.matrix());
  Eigen::VectorXd scale = remaining.scales(J);
  if (!(scale.minCoeff() > 0.0) || !scale.allFinite() || !L.allFinite()) return false;
  J *= scale.cwiseInverse().asDiagonal();
  L *= scale.cwiseInverse().asDiagonal();
  Eigen::ColPivHouseholderQR<Eigen::MatrixXd> qr(J.transpose());
  qr.setThreshold(kRankTolerance);
  Eigen::MatrixXd rest = qr.householderQ().transpose() * L.transpose();
  const auto beyond = rest.bottomRows(rest.rows() - qr.rank());
  for (Eigen::Index row = 0; row < L.rows(); ++row) {
    if (beyond.col(row).norm() > kSameRow * L.row(row).norm()) return false;
  }
  return true;
}

bool others_say_what_was_lost(const LinearModels& models, const JournaledValues& estimate) {
  for (const LinearModels::Lost& lost : models.lost()) {
    if (lost.factor == nullptr) return false;
    for (int slot : lost.slots) {
      if (!estimate->occupied(slot)) return false;
    }
  }
  return models.lost().empty() || others_say_what_was_lost(models, estimate, kNear) ||
         others_say_what_was_lost(models, estimate, kSmall);
}

}  // namespace

bool are_determined(const std::vector<int>& slots, const LinearModels& models,
                    const JournaledValues& estimate, const HybridGraph& graph,
                    const Assignment& assignment) {
  const Terms& terms = models.terms();
  for (int slot : slots) {
    const std::vector<int>& own = terms.of_variable(slot);
    if (std::none_of(own.begin(), own.end(), [&](int t) { return terms[t].tree_factor >= 0; }))
      return false;
  }
  int dims = 0;
  for (Key key : estimate.inserted()) dims += estimate->type(key).dim;
  if (dims <= kSmall && others_say_what_was_lost(models, estimate)) {
    return new_variables_are_determined(terms, estimate);
  }
  const auto weak =
      models.weak_are_coupled() ? WeakComponents::kCoupled : WeakComponents::kUncoupled;
  return free_variables(graph, {estimate.get(), assignment}, weak).empty();
}

}  // namespace hybrid
