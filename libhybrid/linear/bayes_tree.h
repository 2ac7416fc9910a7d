// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, the hybrid mapping authors
#pragma once

#include <Eigen/Core>
#include <cstddef>
#include <functional>
#include <utility>
#include <vector>

#include "libhybrid/linear/block_pool.h"
#include "libhybrid/linear/elimination.h"
#include "libhybrid/linear/front.h"
#include "libhybrid/linear/pool.h"

namespace hybrid {

/// What one elimination did.
struct EliminationReport {
  int variables = 0;  ///< variables eliminated again
  int cliques = 0;    ///< cliques made
  /// Variable whose pivot was not positive, or -1: it is under-constrained, and nothing has
  /// changed.
  int singular = -1;
};

/// The Bayes tree of a linear least-squares problem min ||J d + r||^2 (Kaess et al., iSAM2): the
/// square-root information matrix as a tree of cliques, updated by re-eliminating only the part
/// that a change touches. Variables and factors are small integers. Changes are gathered until
/// `eliminate`, which applies them all or, where the system is singular, none.
class BayesTree {
 public:
  /// A new variable with delta zero; `v` may be the number of one that was removed.
  void add_variable(int v, int dim);
  /// The factors that hold it must be removed in the same transaction.
  void remove_variable(int v);

  /// A new factor with an all-zero Hessian to be filled in through `hessian`. Returns its number.
  int add_factor(const std::vector<int>& variables);
  void remove_factor(int f);
  /// The augmented Hessian [J r]'[J r] of a factor for writing: lower triangle, column-major, order
  /// hessian_order(f). Marks the factor as changed.
  double* hessian(int f);
  int hessian_order(int f) const { return factors_[f].order; }

  /// Starts the step of a variable at zero again, after its linearisation point has moved there.
  void reset_delta(int v);

  /// Applies the changes. `last` lists variables to be eliminated last, e.g. the newest pose.
  EliminationReport eliminate(const std::vector<int>& last);

  /// Takes back all changes since the last `eliminate`.
  void abandon() { roll_back(); }

  /// Back-substitutes from the cliques made since the last call downwards, and below them as long
  /// as moving a clique lowers the linearised objective by more than `threshold`. Returns the
  /// variables whose step changed.
  const std::vector<int>& solve(double threshold);

  /// Half the squared residual that the linear model of a factor predicts at the present steps.
  double linear_cost(int f) const;

  /// Overrides the step of a variable; its clique is solved again by the next `solve`.
  void set_delta(int v, const double* step);

  const double* delta(int v) const { return deltas_.at(variables_[v].delta); }
  int dim(int v) const { return variables_[v].dim; }

  /// Joint covariance of some variables, in their order: forward substitution along their paths to
  /// the root, nothing else of the tree.
  Eigen::MatrixXd joint_covariance(const std::vector<int>& variables) const;
  /// Covariances of all variables by one recursion from the roots (Takahashi), visited as
  /// visit(variable, dim x dim covariance).
  void visit_covariances(
      const std::function<void(int variable, const Eigen::MatrixXd& covariance)>& visit) const;

  int clique_count() const { return clique_count_; }
  /// Doubles held by the cliques: the fill of the factor.
  std::size_t factor_size() const;
  std::size_t bytes() const;
  /// Pairs (row, column) of variables with a block in the factor, row eliminated after column.
  std::vector<std::pair<int, int>> blocks() const;
  /// All variables in elimination order, children before parents.
  std::vector<int> order() const;

 private:
  struct VariableState {
    int dim = 0;
    int clique = -1;
    std::size_t delta = 0;
  };
  struct FactorState {
    std::vector<int> variables;
    int order = 0;
    std::size_t hessian = 0;
    int clique = -1;  // where it is assembled
    bool alive = false;
  };
  struct Clique {
    int parent = -1;
    std::vector<int> children;
    std::vector<int> variables;  // frontals, then separators
    int frontals = 0;            // how many variables are frontal
    int frontal_dim = 0;
    int order = 0;  // rows of `columns`: frontal, separator, one for the right-hand side
    std::vector<int> factors;
    BlockPool::Block storage;
    double* columns = nullptr;  // order x frontal_dim: L, with the right-hand side as last row
    double* update = nullptr;   // packed lower triangle of the Schur complement
    bool detached = false;      // being replaced
    bool pending = false;       // its step was overridden: to be solved again
  };
  struct Saved {  // for roll-back
    int id;
    std::vector<double> values;
  };

  int new_clique();
  void free_factor(int f);
  void free_clique(int c);
  void touch(int clique);
  void detach_top();
  void gather_problem(const std::vector<int>& last);
  int make_clique(const SymbolicClique& symbolic, const std::vector<int>& made);
  void assemble(const Clique& clique, const SymbolicClique& symbolic, const std::vector<int>& made);
  void commit(const std::vector<SymbolicClique>& symbolic, const std::vector<int>& made);
  void roll_back();
  void clear_transaction();
  void propagate(std::vector<int>& stack, double threshold);
  bool solve_clique(Clique& clique, double threshold);
  const double* update_column(const Clique& clique, int k) const;
  std::vector<int> top_down() const;

  std::vector<VariableState> variables_;
  std::vector<FactorState> factors_;
  std::vector<int> free_factors_;
  std::vector<Clique> cliques_;
  std::vector<int> free_cliques_;
  int clique_count_ = 0;
  BlockPool blocks_;
  Pool<double> hessians_;
  Pool<double> deltas_;

  // The transaction under way.
  std::vector<int> touched_;
  std::vector<int> new_variables_, removed_variables_;
  std::vector<int> new_factors_, removed_factors_;
  std::vector<Saved> saved_hessians_, saved_deltas_;

  // Scratch of `eliminate` and `solve`.
  std::vector<int> detached_, orphans_, affected_;
  std::vector<int> local_;   // by variable: index among the affected, or -1
  std::vector<int> offset_;  // by variable: row in the front being assembled
  Hypergraph problem_;
  std::vector<int> group_;
  std::vector<int> edge_factor_;  // by edge of the problem: its factor, or -1 - orphan
  Front front_;
  std::vector<int> fresh_, pending_;
  std::vector<int> changed_;
  std::vector<char> changed_mark_;
  std::vector<double> step_, rhs_;
};

}  // namespace hybrid
