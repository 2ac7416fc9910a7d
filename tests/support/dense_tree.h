// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, the hybrid mapping authors
#pragma once

#include <gtest/gtest.h>

#include <Eigen/Dense>
#include <map>
#include <set>
#include <vector>

#include "libhybrid/linear/bayes_tree.h"
#include "tests/support/random.h"

namespace hybrid::testing {

struct Dense {
  Eigen::MatrixXd information;
  Eigen::VectorXd gradient;
  std::map<int, int> first;  // row by variable
};

/// A Bayes tree and the dense system that it represents.
class Pair {
 public:
  explicit Pair(std::uint64_t seed) : random_(seed) {}

  /// A random change of variables and factors, not yet eliminated.
  void change() {
    next_dims_ = dims_;
    next_factors_ = factors_;
    const int fresh = random_.below(4);
    for (int k = 0; k < fresh; ++k) add_variable();
    const int more = random_.below(4);
    for (int k = 0; k < more && !next_dims_.empty(); ++k) add_factor({any(), any()});
    if (random_.below(3) == 0 && !factors_.empty()) remove_factor(random_factor());
    for (int k = 0; k < 2; ++k) {  // may pick the same one twice
      if (random_.below(2) != 0 || factors_.empty()) continue;
      const int f = random_factor();
      if (next_factors_.count(f) != 0) fill(f);
    }
    if (random_.below(6) == 0 && !dims_.empty()) remove_variable(old_variable());
    if (random_.below(2) == 0 && !dims_.empty()) {
      const int v = old_variable();
      if (next_dims_.count(v) != 0) tree_.reset_delta(v);
      if (next_dims_.count(v) != 0) tree_.reset_delta(v);
    }
    if (random_.below(12) == 0) add_variable(false);
    if (random_.below(12) == 0) {  // may leave variables without a factor
      const auto held = next_factors_;
      for (const auto& [f, factor] : held) {
        if (factors_.count(f) != 0 && factor.variables.back() % 5 == 1) remove_factor(f);
      }
    }
  }

  /// A random addition: variables that one factor each determines beside another one, and factors.
  void grow() {
    next_dims_ = dims_;
    next_factors_ = factors_;
    for (int k = random_.below(3); k > 0; --k) {
      const int other = any();
      const int v = add_variable(false);
      add_factor({v, other}, next_dims_[v]);
    }
    for (int k = random_.below(3); k > 0; --k) add_factor({any(), any()}, 1 + random_.below(6));
  }

  /// Takes it into the solution without an elimination, where that can be done.
  bool defer(double share = 1e9) {
    if (!tree_.defer(share)) return false;
    dims_ = next_dims_;
    factors_ = next_factors_;
    return true;
  }

  EliminationReport eliminate() {
    std::vector<int> last;
    for (const auto& [v, dim] : next_dims_) {
      if (random_.below(4) == 0) last.push_back(v);
    }
    const EliminationReport report = tree_.eliminate(last);
    if (report.singular < 0) {
      dims_ = next_dims_;
      factors_ = next_factors_;
    }
    return report;
  }

  /// Restores the state copied in `committed`, except for the random numbers.
  void roll_back(const Pair& committed) {
    tree_.roll_back(mark_);
    dims_ = next_dims_ = committed.dims_;
    factors_ = next_factors_ = committed.factors_;
    gone_ = committed.gone_;
  }
  void commit() {
    tree_.commit();
    mark_ = tree_.mark();
    gone_.clear();
  }
  void seed(std::uint64_t seed) { random_ = Random(seed); }

  Dense dense(bool next) const {
    Dense d;
    int n = 0;
    for (const auto& [v, dim] : next ? next_dims_ : dims_) {
      d.first[v] = n;
      n += dim;
    }
    d.information = Eigen::MatrixXd::Zero(n, n);
    d.gradient = Eigen::VectorXd::Zero(n);
    for (const auto& [f, factor] : next ? next_factors_ : factors_) {
      Eigen::MatrixXd all = Eigen::MatrixXd::Zero(factor.a.rows(), n);
      int column = 0;
      for (int v : factor.variables) {
        const int dim = next_dims_.count(v) != 0 ? next_dims_.at(v) : dims_.at(v);
        all.middleCols(d.first.at(v), dim) = factor.a.middleCols(column, dim);
        column += dim;
      }
      d.information += all.transpose() * all;
      d.gradient += all.transpose() * factor.a.rightCols(1);
    }
    return d;
  }

  /// The whole state of the tree as numbers: steps, factors, cliques and covariances.
  std::vector<double> state() const {
    std::vector<double> all = {static_cast<double>(tree_.cliques().factor_size()),
                               static_cast<double>(tree_.cliques().count()),
                               tree_.log_determinant()};
    for (const auto& [v, dim] : dims_)
      all.insert(all.end(), tree_.system().delta(v), tree_.system().delta(v) + dim);
    for (const auto& [f, factor] : factors_) all.push_back(tree_.system().linear_cost(f));
    for (int v : tree_.cliques().order()) all.push_back(v);
    for (const auto& [a, b] : tree_.cliques().blocks())
      all.insert(all.end(), {double(a), double(b)});
    tree_.covariances().visit([&](int, const Eigen::MatrixXd& covariance) {
      all.insert(all.end(), covariance.data(), covariance.data() + covariance.size());
    });
    return all;
  }

  void expect_solution(double tolerance) {
    const Dense d = dense(false);
    const Eigen::VectorXd x = -d.information.llt().solve(d.gradient);
    for (const auto& [v, dim] : dims_) {
      const Eigen::Map<const Eigen::VectorXd> delta(tree_.system().delta(v), dim);
      EXPECT_LT((delta - x.segment(d.first.at(v), dim)).norm(), tolerance) << "variable " << v;
    }
  }

  void expect_covariances(double tolerance) {
    const Dense d = dense(false);
    const Eigen::MatrixXd sigma = d.information.inverse();
    tolerance *= std::max(1.0, sigma.cwiseAbs().maxCoeff());
    std::size_t visited = 0;
    tree_.covariances().visit([&](int v, const Eigen::MatrixXd& covariance) {
      ++visited;
      const int at = d.first.at(v);
      const int dim = dims_.at(v);
      EXPECT_LT((covariance - sigma.block(at, at, dim, dim)).norm(), tolerance);
    });
    EXPECT_EQ(visited, dims_.size());
    std::set<int> some;
    for (int k = 0; k < 4; ++k) some.insert(old_variable());
    const std::vector<int> chosen(some.rbegin(), some.rend());
    const Eigen::MatrixXd joint = tree_.covariances().joint(chosen);
    int row = 0;
    for (int a : chosen) {
      int column = 0;
      for (int b : chosen) {
        EXPECT_LT((joint.block(row, column, dims_.at(a), dims_.at(b)) -
                   sigma.block(d.first.at(a), d.first.at(b), dims_.at(a), dims_.at(b)))
                      .norm(),
                  tolerance);
        column += dims_.at(b);
      }
      row += dims_.at(a);
    }
  }

  void disturb() {
    const int v = old_variable();
    const std::vector<double> step(dims_.at(v), random_.normal());
    tree_.set_delta(v, step.data());
  }

  BayesTree& tree() { return tree_; }
  bool empty() const { return dims_.empty(); }

 private:
  struct Factor {
    std::vector<int> variables;
    Eigen::MatrixXd a;  // [J r]
  };

  int any() { return std::next(next_dims_.begin(), random_.below(next_dims_.size()))->first; }
  int old_variable() { return std::next(dims_.begin(), random_.below(dims_.size()))->first; }
  int random_factor() { return std::next(factors_.begin(), random_.below(factors_.size()))->first; }

  /// Adds a variable, mostly with a factor to another variable or a prior.
  int add_variable(bool held = true) {
    int v = 0;
    while (next_dims_.count(v) != 0 || dims_.count(v) != 0 || gone_.count(v) != 0) ++v;
    const bool alone = next_dims_.empty() || random_.below(10) == 0;
    const int other = alone ? v : any();
    next_dims_[v] = 1 + random_.below(6);
    tree_.add_variable(v, next_dims_[v]);
    if (!held) return v;
    add_factor({v});
    if (!alone) add_factor({v, other});
    return v;
  }

  void add_factor(const std::set<int>& variables, int rows = 6) {
    Factor factor;
    factor.variables.assign(variables.begin(), variables.end());
    if (random_.below(2) == 0) std::reverse(factor.variables.begin(), factor.variables.end());
    const int f = tree_.add_factor(factor.variables);
    next_factors_[f] = factor;
    fill(f, rows);
  }

  void fill(int f, int rows = 6) {
    Factor& factor = next_factors_.at(f);
    int columns = 1;
    for (int v : factor.variables) columns += next_dims_.at(v);
    factor.a.resize(rows, columns);
    for (int i = 0; i < factor.a.size(); ++i) factor.a.data()[i] = random_.normal();
    ASSERT_EQ(tree_.system().factor(f).order, columns);
    const Eigen::MatrixXd h = factor.a.transpose() * factor.a;
    for (int j = 0; j < columns; ++j) {
      std::copy_n(h.col(j).data() + j, columns - j,
                  packed_column(tree_.hessian(f), columns, j) + j);
    }
  }

  void remove_factor(int f) {
    if (next_factors_.erase(f) != 0) tree_.remove_factor(f);
  }

  void remove_variable(int v) {
    std::vector<int> holders;
    for (const auto& [f, factor] : next_factors_) {
      if (std::count(factor.variables.begin(), factor.variables.end(), v) != 0)
        holders.push_back(f);
    }
    for (int f : holders) remove_factor(f);
    next_dims_.erase(v);
    gone_.insert(v);
    tree_.remove_variable(v);
  }

  Random random_;
  BayesTree tree_;
  BayesTree::Mark mark_;  // of the last commit
  std::map<int, int> dims_, next_dims_;
  std::set<int> gone_;  // since the last commit
  std::map<int, Factor> factors_, next_factors_;
};

}  // namespace hybrid::testing
