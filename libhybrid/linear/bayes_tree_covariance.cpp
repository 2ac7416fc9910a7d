// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, the hybrid mapping authors
#include <Eigen/Core>
#include <algorithm>

#include "libhybrid/linear/bayes_tree.h"
#include "libhybrid/linear/detail/substitute.h"

namespace hybrid {

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

Eigen::MatrixXd BayesTree::joint_covariance(const std::vector<int>& variables) const {
  int dims = 0;
  for (int v : variables) dims += variables_[v].dim;
  return joint_covariance(variables, Eigen::MatrixXd::Identity(dims, dims));
}

// With the factor L of the information matrix, the covariance is z' z where L z = J'. A column of z
// is zero off the paths of its variables to the root, so only the union of the paths is visited.
// What is common to the variables cancels on the way, before it is squared.
Eigen::MatrixXd BayesTree::joint_covariance(const std::vector<int>& variables,
                                            const Eigen::MatrixXd& J) const {
  // Each path ends where it meets an earlier one; later paths come first, so that children precede
  // their parents.
  std::vector<std::vector<int>> paths;
  std::vector<char> seen(cliques_.size(), 0);
  for (int v : variables) {
    paths.emplace_back();
    for (int c = variables_[v].clique; c >= 0 && !seen[c]; c = cliques_[c].parent) {
      seen[c] = 1;
      paths.back().push_back(c);
    }
  }
  std::vector<int> path;
  for (auto p = paths.rbegin(); p != paths.rend(); ++p)
    path.insert(path.end(), p->begin(), p->end());

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
  int row = 0;
  for (int c : path) {
    const Clique& clique = cliques_[c];
    const int f = clique.frontal_dim;
    const int height = clique.order - 1;
    Eigen::MatrixXd front = Eigen::MatrixXd::Zero(height, columns);
    front.topRows(f) = z.middleRows(row, f);
    for (int k = 0; k < columns; ++k) {
      substitute(clique.columns(), clique.order, height, f, front.col(k).data());
    }
    z.middleRows(row, f) = front.topRows(f);
    int below = f;
    for (std::size_t k = clique.frontals; k < clique.variables.size(); ++k) {
      const int dim = variables_[clique.variables[k]].dim;
      z.middleRows(first_row(clique.variables[k]), dim) += front.middleRows(below, dim);
      below += dim;
    }
    row += f;
  }
  return z.transpose() * z;
}

// From the roots down: with Sigma_SS of the separator from the parent,
//   Sigma_SF = -Sigma_SS L_SF L_FF^-1  and  Sigma_FF = L_FF^-T (I + L_SF' Sigma_SS L_SF) L_FF^-1.
void BayesTree::visit_covariances(
    const std::function<void(int variable, const Eigen::MatrixXd& covariance)>& visit) const {
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
    const Eigen::Map<const Eigen::MatrixXd> L(clique.columns(), clique.order, f);
    const auto Lff = L.topRows(f).triangularView<Eigen::Lower>();
    const Eigen::MatrixXd inverse = Lff.solve(Eigen::MatrixXd::Identity(f, f));
    const Eigen::MatrixXd gain = L.middleRows(f, s) * inverse;  // L_SF L_FF^-1
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
