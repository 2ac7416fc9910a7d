// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, the hybrid mapping authors
#include "libhybrid/linear/tree/covariances.h"

#include <Eigen/LU>
#include <algorithm>
#include <unordered_map>

#include "libhybrid/core/paced_task.h"
#include "libhybrid/core/rank_update.h"
#include "libhybrid/linear/detail/substitute.h"
#include "libhybrid/linear/tree/clique_charts.h"
#include "libhybrid/linear/with_dim.h"

namespace hybrid {
namespace {

/// Rows := D' rows, or D^-T rows, for as many rows as D has.
void turn_rows(const double* D, bool inverse, Eigen::Ref<Eigen::MatrixXd> rows) {
  const auto dim = static_cast<int>(rows.rows());
  with_dim(dim, [&](auto n) {
    constexpr int kDim = decltype(n)::value;
    Eigen::Matrix<double, kDim, kDim> by =
        Eigen::Map<const Eigen::Matrix<double, kDim, kDim>>(D, dim, dim).transpose();
    if (inverse) by = by.inverse().eval();
    for (Eigen::Index k = 0; k < rows.cols(); ++k) {
      Eigen::Map<Eigen::Matrix<double, kDim, 1>> x(rows.col(k).data(), dim);
      x = (by * x).eval();
    }
  });
}

/// The square-root information of a clique in tangents at the estimates, or where there are no
/// charts, as it is. With the turn D of its tangents, its rows [R_F R_S] are [R_F R_S] D by
/// tangents at the estimates. Where the anchor is in the separator, as it is if that has a pose, or
/// there is no separator, D_SF is zero: what stands on the right of R_F' z is turned by D_FF^-T
/// before, what z leaves for the separator by D after.
class TurnedClique {
 public:
  TurnedClique(const LinearSystem& system, const TreeClique& clique, const Charts* charts)
      : clique_(clique), turned_{system, clique, turn_} {
    if (charts == nullptr) return;
    std::vector<double> steps(clique.order - 1);
    charts->see(clique.variables, 0, clique.frontals, clique.chart(), steps.data(), turn_);
    turns_ = clique.chart().is_moved() ||
             std::any_of(steps.begin(), steps.end(), [](double x) { return x != 0.0; });
  }

  /// Its rows, [L_FF' L_SF'].
  Eigen::MatrixXd rows() const {
    const int f = clique_.frontal_dim;
    const Eigen::Map<const Eigen::MatrixXd> L(clique_.columns(), clique_.order, f);
    Eigen::MatrixXd rows = L.topRows(clique_.order - 1).transpose();
    rows.leftCols(f).triangularView<Eigen::StrictlyLower>().setZero();
    if (!turns_) return rows;
    Eigen::MatrixXd by_anchor = Eigen::MatrixXd::Zero(rows.rows(), turned_.anchor_dim());
    turned_.for_each([&](int, int column, int dim, const double* own, const double* by) {
      const auto part = rows.middleCols(column, dim);
      if (by != nullptr)
        by_anchor += part * Eigen::Map<const Eigen::MatrixXd>(by, dim, by_anchor.cols());
      rows.middleCols(column, dim) =
          (part * Eigen::Map<const Eigen::MatrixXd>(own, dim, dim)).eval();
    });
    rows.middleCols(turned_.anchor_row(), by_anchor.cols()) += by_anchor;
    return rows;
  }

  /// Substitutes forward in the rows of its variables in some right-hand sides.
  void substitute(Eigen::Map<Eigen::MatrixXd> front) const {
    const int f = clique_.frontal_dim;
    const auto height = static_cast<int>(front.rows());
    if (has_frontal_anchor() && height > f) {
      const Eigen::MatrixXd by = rows();
      front.topRows(f) = by.leftCols(f).transpose().lu().solve(front.topRows(f)).eval();
      front.bottomRows(height - f).noalias() -=
          by.rightCols(height - f).transpose() * front.topRows(f);
      return;
    }
    if (turns_) turn_frontals(front);
    Eigen::MatrixXd given;
    if (turns_ && turn_.anchor >= 0) given = front.topRows(f);
    substitute_all(clique_.columns(), clique_.order, height, f, front.data(),
                   static_cast<int>(front.cols()));
    if (turns_ && height > f) turn_separator(given, front);
  }

 private:
  bool has_frontal_anchor() const {
    return turns_ && turn_.anchor >= 0 && turn_.anchor < clique_.frontals;
  }

  void turn_frontals(Eigen::Ref<Eigen::MatrixXd> front) const {
    const int anchor = turned_.anchor_row(), anchor_dim = turned_.anchor_dim();
    const double* turn_of_anchor = nullptr;
    turned_.for_each([&](int k, int row, int dim, const double* own, const double* by) {
      if (k >= clique_.frontals) return;
      if (k == turn_.anchor) {
        turn_of_anchor = own;
        return;
      }
      turn_rows(own, true, front.middleRows(row, dim));
      if (!has_frontal_anchor() || by == nullptr) return;
      front.middleRows(anchor, anchor_dim) -=
          Eigen::Map<const Eigen::MatrixXd>(by, dim, anchor_dim).transpose() *
          front.middleRows(row, dim);
    });
    if (has_frontal_anchor()) turn_rows(turn_of_anchor, true, front.middleRows(anchor, anchor_dim));
  }

  /// `given` are the rows of the frontals before the substitution.
  void turn_separator(const Eigen::MatrixXd& given, Eigen::Ref<Eigen::MatrixXd> front) const {
    const int anchor_dim = turned_.anchor_dim();
    Eigen::MatrixXd by_anchor = Eigen::MatrixXd::Zero(anchor_dim, front.cols());
    turned_.for_each([&](int k, int row, int dim, const double* own, const double* by) {
      const bool frontal = k < clique_.frontals;
      if (by != nullptr) {
        const Eigen::Map<const Eigen::MatrixXd> turn_by(by, dim, anchor_dim);
        if (frontal) {
          by_anchor -= turn_by.transpose() * given.middleRows(row, dim);
        } else {
          by_anchor += turn_by.transpose() * front.middleRows(row, dim);
        }
      }
      if (!frontal) turn_rows(own, false, front.middleRows(row, dim));
    });
    front.middleRows(turned_.anchor_row(), anchor_dim) += by_anchor;
  }

  const TreeClique& clique_;
  Turn turn_;
  bool turns_ = false;
  TurnedVariables turned_;
};

/// Rows of the separator of a clique among all rows of its parent. `offset`, by variable, is
/// scratch.
std::vector<int> separator_rows(const LinearSystem& system, const TreeClique& clique,
                                const TreeClique& parent, std::vector<int>& offset) {
  int at = 0;
  for (int v : parent.variables) {
    offset[v] = at;
    at += system.dim(v);
  }
  std::vector<int> rows;
  for (std::size_t k = clique.frontals; k < clique.variables.size(); ++k) {
    const int v = clique.variables[k];
    for (int i = 0; i < system.dim(v); ++i) rows.push_back(offset[v] + i);
  }
  return rows;
}

}  // namespace

Eigen::MatrixXd TreeCovariances::joint(const std::vector<int>& variables) const {
  int dims = 0;
  for (int v : variables) dims += system_.dim(v);
  return joint(variables, Eigen::MatrixXd::Identity(dims, dims));
}

// With the factor L of the information matrix, the covariance is z' z where L z = J', less what
// pending rows say. What is common to the variables cancels on the way, before it is squared.
Eigen::MatrixXd TreeCovariances::joint(const std::vector<int>& variables,
                                       const Eigen::MatrixXd& J) const {
  const PathRows rows = substitute(variables, J);
  Eigen::MatrixXd out = Eigen::MatrixXd::Zero(J.rows(), J.rows());
  rank_update(out, rows.z.transpose(), 1.0);
  if (!pending_.empty()) {
    rank_update(out, pending_.reduction(rows, cliques_).transpose(), -1.0);
  }
  out.triangularView<Eigen::StrictlyUpper>() = out.transpose();
  return out;
}

// A column of z is zero off the paths of its variables to the root, so only the union of the paths
// is visited.
PathRows TreeCovariances::substitute(const std::vector<int>& variables,
                                     const Eigen::MatrixXd& J) const {
  PathRows out{cliques_.paths_of(variables, system_), {}};
  const std::vector<int>& path = out.path;
  const auto columns = static_cast<int>(J.rows());
  std::unordered_map<int, int> row_of;  // first row by variable
  int rows = 0, tallest = 0;
  for (int c : path) {
    const TreeClique& clique = cliques_[c];
    tallest = std::max(tallest, clique.order - 1);
    for (int k = 0; k < clique.frontals; ++k) {
      row_of.emplace(clique.variables[k], rows);
      rows += system_.dim(clique.variables[k]);
    }
  }
  Eigen::MatrixXd& z = out.z;
  z = Eigen::MatrixXd::Zero(rows, columns);
  if (columns == 0) return out;
  const auto rows_of = [&](int v) { return z.middleRows(row_of.at(v), system_.dim(v)); };

  int own = 0;  // first column of a variable in J
  for (int v : variables) {
    rows_of(v) += J.middleCols(own, system_.dim(v)).transpose();
    own += system_.dim(v);
  }
  std::vector<double> storage(static_cast<std::size_t>(tallest) * columns);
  int row = 0;
  for (int c : path) {
    const TreeClique& clique = cliques_[c];
    const int f = clique.frontal_dim;
    const int height = clique.order - 1;
    Eigen::Map<Eigen::MatrixXd> front(storage.data(), height, columns);
    front.topRows(f) = z.middleRows(row, f);
    front.bottomRows(height - f).setZero();
    TurnedClique(system_, clique, charts_).substitute(front);
    note_work(double(height) * f * columns);
    z.middleRows(row, f) = front.topRows(f);
    int below = f;
    for (std::size_t k = clique.frontals; k < clique.variables.size(); ++k) {
      const int dim = system_.dim(clique.variables[k]);
      rows_of(clique.variables[k]) += front.middleRows(below, dim);
      below += dim;
    }
    row += f;
  }
  return out;
}

// From the roots down: with Sigma_SS of the separator from the parent,
//   Sigma_SF = -Sigma_SS L_SF L_FF^-1  and  Sigma_FF = L_FF^-T (I + L_SF' Sigma_SS L_SF) L_FF^-1.
// Pending rows, with the rows X of their reduction, take Z Z' from that, where
//   Z_F = L_FF^-T (X_F - L_SF' Z_S).
void TreeCovariances::visit(
    const std::function<void(int variable, const Eigen::MatrixXd& covariance)>& visit) const {
  const std::vector<int> cliques = cliques_.top_down();
  const int end = cliques.empty() ? 0 : *std::max_element(cliques.begin(), cliques.end()) + 1;
  // Of a clique's variables, until its children are done.
  std::vector<Eigen::MatrixXd> joint(end), reduced(pending_.empty() ? 0 : end);
  std::vector<int> waiting(end, 0);
  std::vector<int> offset(system_.variable_count(), 0);
  for (int c : cliques) {
    const TreeClique& clique = cliques_[c];
    const int f = clique.frontal_dim;
    const int s = clique.separator_dim();
    Eigen::MatrixXd& sigma = joint[c];
    sigma.resize(f + s, f + s);
    Eigen::MatrixXd reduced_above;
    if (s > 0) {
      const std::vector<int> rows =
          separator_rows(system_, clique, cliques_[clique.parent], offset);
      sigma.bottomRightCorner(s, s) = joint[clique.parent](rows, rows);
      if (!pending_.empty()) reduced_above = reduced[clique.parent](rows, Eigen::all);
    }
    const Eigen::MatrixXd by = TurnedClique(system_, clique, charts_).rows();
    const Eigen::MatrixXd inverse = by.leftCols(f).inverse().transpose();
    const Eigen::MatrixXd gain = by.rightCols(s).transpose() * inverse;
    sigma.bottomLeftCorner(s, f).noalias() = -sigma.bottomRightCorner(s, s) * gain;
    sigma.topLeftCorner(f, f).noalias() =
        inverse.transpose() * inverse - gain.transpose() * sigma.bottomLeftCorner(s, f);
    sigma.topRightCorner(f, s) = sigma.bottomLeftCorner(s, f).transpose();
    if (!pending_.empty()) {
      Eigen::MatrixXd own = pending_.reduction(clique);
      if (s > 0) own -= by.rightCols(s) * reduced_above;
      reduced[c].resize(f + s, own.cols());
      reduced[c].topRows(f).noalias() = inverse.transpose() * own;
      if (s > 0) reduced[c].bottomRows(s) = reduced_above;
    }
    int row = 0;
    for (int k = 0; k < clique.frontals; ++k) {
      const int dim = system_.dim(clique.variables[k]);
      Eigen::MatrixXd own = sigma.block(row, row, dim, dim);
      if (!pending_.empty()) {
        const auto Z = reduced[c].middleRows(row, dim);
        own -= Z * Z.transpose();
      }
      visit(clique.variables[k], own);
      row += dim;
    }
    const auto forget = [&](int done) {
      joint[done].resize(0, 0);
      if (!pending_.empty()) reduced[done].resize(0, 0);
    };
    waiting[c] = static_cast<int>(clique.children.size());
    if (waiting[c] == 0) forget(c);
    if (clique.parent >= 0 && --waiting[clique.parent] == 0) forget(clique.parent);
  }
}

}  // namespace hybrid
