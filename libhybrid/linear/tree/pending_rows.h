// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, the hybrid mapping authors
#pragma once

#include <Eigen/Core>
#include <cstddef>
#include <vector>

#include "libhybrid/export.h"
#include "libhybrid/geometry/eigen.h"
#include "libhybrid/linear/tree/cliques.h"

namespace HYBRID_API hybrid {

/// A system S w = c that grows row by row, by its Cholesky factor. What is cut off again leaves no
/// trace.
class BorderedCholesky {
 public:
  int size() const { return static_cast<int>(reduced_.size()); }
  /// Appends row i of S, up to its diagonal, and c_i. Returns false, and appends nothing, where the
  /// pivot that is left of the diagonal is below `least`.
  bool append(const double* row, double c, double least);
  void truncate(int size);
  /// w.
  void solve(double* w) const;
  /// L^-1 x in place.
  void substitute(double* x) const;
  /// log det S.
  double log_determinant() const;
  std::size_t bytes() const { return (factor_.capacity() + reduced_.capacity()) * sizeof(double); }

 private:
  const double* row(int i) const {
    return factor_.data() + static_cast<std::size_t>(i) * (i + 1) / 2;
  }

  std::vector<double> factor_;   // rows of L, each up to its diagonal
  std::vector<double> reduced_;  // L^-1 c
};

/// R^-T J' for rows J about some variables, with R the square-root information matrix of a Bayes
/// tree: zero off the paths of these variables to the root.
struct PathRows {
  std::vector<int> path;  ///< cliques, children before their parents
  Eigen::MatrixXd z;      ///< rows of their frontals, one clique after the other, a column by row
};

/// Factors that are in the solution of a Bayes tree, but not in its cliques yet.
///
/// With the tree's rows y = R d + z, the rows A d + b of such a factor are c + Y' y, where Y = R^-T
/// A'. The minimum of |y|^2 + |c + Y' y|^2 is at y = -Y w with (I + Y' Y) w = c. So all that the
/// tree sees of them is a pull, Y w, on the right-hand sides of the cliques on their paths.
class PendingRows {
 public:
  bool empty() const { return now().sets.empty(); }
  int factors() const { return static_cast<int>(now().sets.size()); }
  int factor(int k) const { return now().sets[k].factor; }

  /// Adds rows c + Y' y of a factor. Returns false, and adds nothing, where they would be lost in
  /// rounding.
  bool add(int factor, const PathRows& Y, const Eigen::VectorXd& c, Cliques& cliques);
  /// Makes the pulls anew, and lists the cliques that feel them as to be solved.
  void pull(Cliques& cliques);
  /// The pull on the right-hand side of a clique; null if there is none.
  const double* pull_on(const TreeClique& clique) const {
    return clique.pulled < 0 ? nullptr : now().meetings[clique.pulled].pull.data();
  }

  /// Adds Y' y of a clique for all rows.
  void add_rows(const TreeClique& clique, const double* y, std::vector<double>& rows) const;

  /// X with which the covariance of rows J is that by the tree less X' X; a column by row.
  Eigen::MatrixXd reduction(const PathRows& rows, const Cliques& cliques) const;
  /// The rows X of a clique's frontals in y, with which that of y is I - X X'.
  Eigen::MatrixXd reduction(const TreeClique& clique) const;
  double log_determinant() const { return now().system.log_determinant(); }

  /// What they have cost since the last elimination, and what that has cost, in multiplications of
  /// an elimination.
  double rent() const { return rent_; }
  double price() const { return price_; }
  void pay(double multiplications);
  /// A variable hangs below those that came since the last elimination: what is asked of the newest
  /// goes through all of them.
  void pay_for_leaf(double work) { pay(++leaves_ * work); }
  /// All of them have been eliminated, at a price.
  void retire(double price);

  struct Mark {
    std::size_t generation = 1;
    int factors = 0;
    double rent = 0.0, price = 0.0;
    int leaves = 0;
  };
  void commit() noexcept;
  Mark mark() const { return {generations_.size(), factors(), rent_, price_, leaves_}; }
  /// To be called when the cliques have been rolled back.
  void roll_back(const Mark& mark, Cliques& cliques, LinearSystem& system) noexcept;
  /// Takes back those that were added after there were so many.
  void truncate(int factors, Cliques& cliques) noexcept;
  std::size_t bytes() const;

 private:
  /// A clique on the paths of some rows.
  struct Meeting {
    int clique = -1;
    std::vector<int> rows;        // numbers
    std::vector<double> Y, pull;  // frontal dimension x rows, and the pull
  };
  struct Set {
    int factor = -1;
    int first_row = 0;
    std::vector<int> meetings;
  };
  struct Generation {
    std::vector<Set> sets;
    std::vector<Meeting> meetings;
    BorderedCholesky system;  // I + Y' Y
    std::vector<double> w;
  };
  Generation& now() { return generations_.back(); }
  const Generation& now() const { return generations_.back(); }
  void set_pulls() noexcept;

  std::vector<Generation> generations_{1};  // the last is at work, those before have been retired
  double rent_ = 0.0, price_ = 0.0;
  int leaves_ = 0;
};

/// The parts of a Bayes tree, for what changes it.
struct TreeParts {
  LinearSystem& system;
  Cliques& cliques;
  PendingRows& pending;

  /// Touches the cliques of the variables of new factors and of those that are pending.
  void touch_waiting() const {
    const auto touch = [&](int f) {
      for (int v : system.factor(f).variables) system.touch_variable(v);
    };
    for (int k = 0; k < pending.factors(); ++k) touch(pending.factor(k));
    for (int f : system.changes(LinearSystem::kNewFactors)) touch(f);
  }
  /// Visits the factors in the detached cliques, and those that are in none.
  template <class Visit>
  void visit_factors(const Visit& visit) const {
    const auto visit_alive = [&](int f) {
      if (system.factor(f).alive) visit(f);
    };
    for (int c : cliques.detached()) {
      for (int f : cliques[c].factors) visit_alive(f);
    }
    for (int k = 0; k < pending.factors(); ++k) visit_alive(pending.factor(k));
    for (int f : system.changes(LinearSystem::kNewFactors)) visit_alive(f);
  }
};

}  // namespace hybrid
