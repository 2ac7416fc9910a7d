// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, the hybrid mapping authors
#include <Eigen/Core>
#include <Eigen/LU>
#include <algorithm>
#include <unordered_set>

#include "libhybrid/core/detail/rank_update.h"
#include "libhybrid/core/paced_task.h"
#include "libhybrid/linear/bayes_tree.h"
#include "libhybrid/linear/detail/substitute.h"
#include "libhybrid/linear/detail/with_dim.h"

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

/// z' z.
Eigen::MatrixXd square(const Eigen::MatrixXd& z) {
  Eigen::MatrixXd out = Eigen::MatrixXd::Zero(z.cols(), z.cols());
  rank_update(out, z.transpose(), 1.0);
  out.triangularView<Eigen::StrictlyUpper>() = out.transpose();
  return out;
}

}  // namespace

/// Cliques from the roots down, parents before children.
std::vector<int> BayesTree::top_down() const {
  std::vector<int> cliques;
  cliques.reserve(clique_count());
  for (int c = 0; c < static_cast<int>(cliques_.size()); ++c) {
    const Clique& clique = cliques_[c];
    if (clique.parent < 0 && !clique.variables.empty() && !clique.detached) cliques.push_back(c);
  }
  for (std::size_t k = 0; k < cliques.size(); ++k) {
    const Clique& clique = cliques_[cliques[k]];
    cliques.insert(cliques.end(), clique.children.begin(), clique.children.end());
  }
  return cliques;
}

/// How the tangents of a clique's chart turn into those at the estimates. Returns false where the
/// two are the same.
bool BayesTree::look(const Clique& clique, const Charts& charts, Turn& turn) const {
  std::vector<double> steps(clique.order - 1);
  charts.see(clique.variables, 0, clique.frontals, clique.chart(), steps.data(), turn);
  return clique.chart().is_moved() ||
         std::any_of(steps.begin(), steps.end(), [](double x) { return x != 0.0; });
}

/// Visits the variables of a clique as visit(number, first row, dim, own turn, turn by the anchor,
/// null if there is none).
template <class Visit>
void BayesTree::for_each_turn(const Clique& clique, const Turn& turn, const Visit& visit) const {
  const int anchor_dim = turn.anchor < 0 ? 0 : variables_[clique.variables[turn.anchor]].dim;
  const double *own = turn.own.data(), *by = turn.by_anchor.data();
  int row = 0;
  for (int k = 0; k < static_cast<int>(clique.variables.size()); ++k) {
    const int dim = variables_[clique.variables[k]].dim;
    visit(k, row, dim, own, dim < anchor_dim ? by : nullptr);
    own += static_cast<std::ptrdiff_t>(dim) * dim;
    by += static_cast<std::ptrdiff_t>(dim) * anchor_dim;
    row += dim;
  }
}

/// The rows and the dimension of the anchor of a turn in a clique.
std::pair<int, int> BayesTree::anchor_rows(const Clique& clique, const Turn& turn) const {
  if (turn.anchor < 0) return {0, 0};
  int row = 0;
  for (int k = 0; k < turn.anchor; ++k) row += variables_[clique.variables[k]].dim;
  return {row, variables_[clique.variables[turn.anchor]].dim};
}

// With the turn D of a clique's tangents, its rows [R_F R_S] are [R_F R_S] D by tangents at the
// estimates. Where the anchor is in the separator, as it is if that has a pose, or there is no
// separator, D_SF is zero: what stands on the right of R_F' z is turned by D_FF^-T before, what z
// leaves for the separator by D after.

/// Turns the rows of the frontals.
void BayesTree::turn_frontals(const Clique& clique, const Turn& turn,
                              Eigen::Ref<Eigen::MatrixXd> front) const {
  const std::pair<int, int> rows = anchor_rows(clique, turn);
  const int anchor = rows.first, anchor_dim = rows.second;
  const bool has_anchor = turn.anchor >= 0 && turn.anchor < clique.frontals;
  const double* turn_of_anchor = nullptr;
  for_each_turn(clique, turn, [&](int k, int row, int dim, const double* own, const double* by) {
    if (k >= clique.frontals) return;
    if (k == turn.anchor) {
      turn_of_anchor = own;
      return;
    }
    turn_rows(own, true, front.middleRows(row, dim));
    if (!has_anchor || by == nullptr) return;
    front.middleRows(anchor, anchor_dim) -=
        Eigen::Map<const Eigen::MatrixXd>(by, dim, anchor_dim).transpose() *
        front.middleRows(row, dim);
  });
  if (has_anchor) turn_rows(turn_of_anchor, true, front.middleRows(anchor, anchor_dim));
}

/// Turns the rows of the separator; `given` are those of the frontals before the substitution.
void BayesTree::turn_separator(const Clique& clique, const Turn& turn, const Eigen::MatrixXd& given,
                               Eigen::Ref<Eigen::MatrixXd> front) const {
  const std::pair<int, int> rows = anchor_rows(clique, turn);
  const int anchor = rows.first, anchor_dim = rows.second;
  Eigen::MatrixXd by_anchor = Eigen::MatrixXd::Zero(anchor_dim, front.cols());
  for_each_turn(clique, turn, [&](int k, int row, int dim, const double* own, const double* by) {
    const bool frontal = k < clique.frontals;
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
  front.middleRows(anchor, anchor_dim) += by_anchor;
}

/// The rows of the square-root information of a clique, [L_FF' L_SF'], by tangents at the
/// estimates.
Eigen::MatrixXd BayesTree::rows_of(const Clique& clique, const Charts* charts) const {
  const int f = clique.frontal_dim;
  const Eigen::Map<const Eigen::MatrixXd> L(clique.columns(), clique.order, f);
  Eigen::MatrixXd rows = L.topRows(clique.order - 1).transpose();
  rows.leftCols(f).triangularView<Eigen::StrictlyLower>().setZero();
  Turn turn;
  if (charts == nullptr || !look(clique, *charts, turn)) return rows;
  const auto [anchor, anchor_dim] = anchor_rows(clique, turn);
  Eigen::MatrixXd by_anchor = Eigen::MatrixXd::Zero(rows.rows(), anchor_dim);
  for_each_turn(clique, turn, [&](int, int column, int dim, const double* own, const double* by) {
    const auto part = rows.middleCols(column, dim);
    if (by != nullptr)
      by_anchor += part * Eigen::Map<const Eigen::MatrixXd>(by, dim, by_anchor.cols());
    rows.middleCols(column, dim) = (part * Eigen::Map<const Eigen::MatrixXd>(own, dim, dim)).eval();
  });
  rows.middleCols(anchor, anchor_dim) += by_anchor;
  return rows;
}

Eigen::MatrixXd BayesTree::joint_covariance(const std::vector<int>& variables,
                                            const Charts* charts) const {
  int dims = 0;
  for (int v : variables) dims += variables_[v].dim;
  return joint_covariance(variables, Eigen::MatrixXd::Identity(dims, dims), charts);
}

/// The cliques on the paths of some variables to the root, children before their parents.
std::vector<int> BayesTree::paths_of(const std::vector<int>& variables) const {
  // Each path ends where it meets an earlier one; later paths come first.
  std::vector<std::vector<int>> paths;
  std::unordered_set<int> seen;
  for (int v : variables) {
    paths.emplace_back();
    for (int c = variables_[v].clique; c >= 0 && seen.insert(c).second; c = cliques_[c].parent) {
      paths.back().push_back(c);
    }
  }
  std::vector<int> all;
  for (auto p = paths.rbegin(); p != paths.rend(); ++p) all.insert(all.end(), p->begin(), p->end());
  return all;
}

// With the factor L of the information matrix, the covariance is z' z where L z = J'. A column of z
// is zero off the paths of its variables to the root, so only the union of the paths is visited.
// What is common to the variables cancels on the way, before it is squared.
Eigen::MatrixXd BayesTree::joint_covariance(const std::vector<int>& variables,
                                            const Eigen::MatrixXd& J, const Charts* charts) const {
  const std::vector<int> path = paths_of(variables);
  const auto columns = static_cast<int>(J.rows());
  std::vector<std::pair<int, int>> row_of;  // (variable, first row), sorted
  int rows = 0;
  for (int c : path) {
    for (int k = 0; k < cliques_[c].frontals; ++k) {
      row_of.emplace_back(cliques_[c].variables[k], rows);
      rows += variables_[cliques_[c].variables[k]].dim;
    }
  }
  std::sort(row_of.begin(), row_of.end());
  const auto first_row = [&](int v) {
    return std::lower_bound(row_of.begin(), row_of.end(), std::make_pair(v, 0))->second;
  };

  Eigen::MatrixXd z = Eigen::MatrixXd::Zero(rows, columns);
  int own = 0;  // first column of a variable in J
  for (int v : variables) {
    const int dim = variables_[v].dim;
    z.middleRows(first_row(v), dim) += J.middleCols(own, dim).transpose();
    own += dim;
  }
  int tallest = 0;
  for (int c : path) tallest = std::max(tallest, cliques_[c].order - 1);
  std::vector<double> storage(static_cast<std::size_t>(tallest) * columns);
  int row = 0;
  Turn turn;
  Eigen::MatrixXd given;
  for (int c : path) {
    const Clique& clique = cliques_[c];
    const int f = clique.frontal_dim;
    const int height = clique.order - 1;
    Eigen::Map<Eigen::MatrixXd> front(storage.data(), height, columns);
    front.topRows(f) = z.middleRows(row, f);
    front.bottomRows(height - f).setZero();
    const bool turned = charts != nullptr && look(clique, *charts, turn);
    if (turned && turn.anchor >= 0 && turn.anchor < clique.frontals && height > f) {
      const Eigen::MatrixXd by = rows_of(clique, charts);
      front.topRows(f) = by.leftCols(f).transpose().lu().solve(front.topRows(f)).eval();
      front.bottomRows(height - f).noalias() -=
          by.rightCols(height - f).transpose() * front.topRows(f);
    } else {
      if (turned) turn_frontals(clique, turn, front);
      if (turned && turn.anchor >= 0) given = front.topRows(f);
      substitute_all(clique.columns(), clique.order, height, f, front.data(), columns);
      if (turned && height > f) turn_separator(clique, turn, given, front);
    }
    note_work(double(height) * f * columns);
    z.middleRows(row, f) = front.topRows(f);
    int below = f;
    for (std::size_t k = clique.frontals; k < clique.variables.size(); ++k) {
      const int dim = variables_[clique.variables[k]].dim;
      z.middleRows(first_row(clique.variables[k]), dim) += front.middleRows(below, dim);
      below += dim;
    }
    row += f;
  }
  return square(z);
}

// From the roots down: with Sigma_SS of the separator from the parent,
//   Sigma_SF = -Sigma_SS L_SF L_FF^-1  and  Sigma_FF = L_FF^-T (I + L_SF' Sigma_SS L_SF) L_FF^-1.
void BayesTree::visit_covariances(
    const std::function<void(int variable, const Eigen::MatrixXd& covariance)>& visit,
    const Charts* charts) const {
  std::vector<Eigen::MatrixXd> joint(
      cliques_.size());  // of a clique's variables, until its children are done
  std::vector<int> waiting(cliques_.size(), 0);
  std::vector<int> offset(variables_.size(), 0);
  for (int c : top_down()) {
    const Clique& clique = cliques_[c];
    const int f = clique.frontal_dim;
    const int s = clique.order - 1 - f;
    Eigen::MatrixXd& sigma = joint[c];
    sigma.resize(f + s, f + s);
    if (s > 0) {
      const Clique& parent = cliques_[clique.parent];
      int at = 0;
      for (int v : parent.variables) {
        offset[v] = at;
        at += variables_[v].dim;
      }
      const Eigen::MatrixXd& above = joint[clique.parent];
      int row = f;
      for (std::size_t i = clique.frontals; i < clique.variables.size(); ++i) {
        const int vi = clique.variables[i];
        int col = f;
        for (std::size_t j = clique.frontals; j < clique.variables.size(); ++j) {
          const int vj = clique.variables[j];
          sigma.block(row, col, variables_[vi].dim, variables_[vj].dim) =
              above.block(offset[vi], offset[vj], variables_[vi].dim, variables_[vj].dim);
          col += variables_[vj].dim;
        }
        row += variables_[vi].dim;
      }
    }
    const Eigen::MatrixXd by = rows_of(clique, charts);
    const Eigen::MatrixXd inverse = by.leftCols(f).inverse().transpose();
    const Eigen::MatrixXd gain = by.rightCols(s).transpose() * inverse;
    sigma.bottomLeftCorner(s, f).noalias() = -sigma.bottomRightCorner(s, s) * gain;
    sigma.topLeftCorner(f, f).noalias() =
        inverse.transpose() * inverse - gain.transpose() * sigma.bottomLeftCorner(s, f);
    sigma.topRightCorner(f, s) = sigma.bottomLeftCorner(s, f).transpose();
    int row = 0;
    for (int k = 0; k < clique.frontals; ++k) {
      const int v = clique.variables[k];
      visit(v, sigma.block(row, row, variables_[v].dim, variables_[v].dim));
      row += variables_[v].dim;
    }
    waiting[c] = static_cast<int>(clique.children.size());
    if (waiting[c] == 0) sigma.resize(0, 0);
    if (clique.parent >= 0 && --waiting[clique.parent] == 0) joint[clique.parent].resize(0, 0);
  }
}

std::vector<int> BayesTree::order() const {
  std::vector<int> order;
  const std::vector<int> cliques = top_down();
  for (auto c = cliques.rbegin(); c != cliques.rend(); ++c) {
    const auto first = cliques_[*c].variables.begin();
    order.insert(order.end(), first, first + cliques_[*c].frontals);
  }
  return order;
}

std::vector<std::pair<int, int>> BayesTree::blocks() const {
  std::vector<std::pair<int, int>> blocks;
  for (const Clique& clique : cliques_) {
    if (clique.detached) continue;
    for (int j = 0; j < clique.frontals; ++j) {
      for (std::size_t i = j; i < clique.variables.size(); ++i) {
        blocks.emplace_back(clique.variables[i], clique.variables[j]);
      }
    }
  }
  return blocks;
}

}  // namespace hybrid
