// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, the hybrid mapping authors
#pragma once

#include <algorithm>
#include <cstddef>
#include <vector>

#include "libhybrid/linear/tree/back_substitution.h"
#include "libhybrid/linear/tree/covariances.h"
#include "libhybrid/linear/tree/deferral.h"
#include "libhybrid/linear/tree/elimination.h"

namespace HYBRID_API hybrid {

/// The Bayes tree of a linear least-squares problem min ||J d + r||^2 (Kaess et al., iSAM2): the
/// square-root information matrix as a tree of cliques, updated by re-eliminating only the part
/// that a change touches. Variables and factors are small integers. Changes are collected until
/// `eliminate`. Changes since a mark after the last `commit` can be rolled back, at a cost that
/// depends on their extent alone.
class BayesTree {
 public:
  /// Variables with their steps, and factors with their Hessians.
  const LinearSystem& system() const { return system_; }
  const Cliques& cliques() const { return cliques_; }

  /// Adds a variable with step zero; `v` may be the number of one whose removal was committed.
  void add_variable(int v, int dim) { system_.add_variable(v, dim); }
  /// Removes a variable; its factors must be removed in the same transaction.
  void remove_variable(int v) { system_.remove_variable(v); }

  /// Adds a factor with an all-zero Hessian, to be filled in through `hessian`. Returns its number.
  /// If it is linearised about so many numbers, these are to be filled in behind the Hessian.
  int add_factor(const std::vector<int>& variables, int points = 0) {
    return system_.add_factor(variables, points);
  }
  void remove_factor(int f) { system_.remove_factor(f); }
  /// The augmented Hessian [J r]'[J r] of a factor for writing: packed lower triangle. Marks the
  /// factor as changed.
  double* hessian(int f) { return system_.edit_hessian(f); }
  /// The points about which a factor is linearised, for writing.
  double* points(int f) { return system_.points(f); }
  /// These points, and the motion of the clique in which it was assembled since.
  Chart chart_of(int f) const {
    const int c = system_.factor(f).clique;
    return {c < 0 ? nullptr : cliques_[c].motion(), system_.points(f)};
  }
  /// Makes the next `eliminate` assemble a factor anew.
  void assemble_again(int f) { system_.touch_factor(f); }
  /// Makes the next `eliminate` eliminate a variable again, and so order it anew.
  void eliminate_again(int v) { system_.touch_variable(v); }

  /// Sets the step of a variable to zero, after its linearisation point has moved by it.
  void reset_delta(int v) {
    eliminate_again(v);
    std::fill_n(system_.edit_delta(v), system_.dim(v), 0.0);
  }
  /// Overrides the step of a variable; its clique is solved again by the next `solve`.
  void set_delta(int v, const double* step) {
    std::copy_n(step, system_.dim(v), system_.edit_delta(v));
    cliques_.set_unsolved(system_.clique_of(v));
  }
  /// Sets the step of a variable from its estimate.
  void set_delta(int v, const Charts& charts) {
    const TreeClique& clique = cliques_[system_.clique_of(v)];
    std::vector<double> steps(clique.order);
    charts.see(clique.variables, 0, clique.chart(), steps.data());
    const double* step = steps.data();
    for (const int* own = clique.variables.data(); *own != v; ++own) step += system_.dim(*own);
    set_delta(v, step);
  }

  /// The factors that the next `eliminate` assembles, as the changes so far stand: new ones, those
  /// whose Hessian was written, and all in the cliques on the paths from these to the root.
  std::vector<int> factors_to_assemble() {
    std::vector<int> factors;
    parts().touch_waiting();
    cliques_.detach(system_.touched());
    parts().visit_factors([&](int f) { factors.push_back(f); });
    cliques_.keep_detached();
    return factors;
  }

  /// Takes the changes into the solution without an elimination, if all that they do is to add
  /// variables that one factor each determines, and factors. Such a variable becomes a clique below
  /// the tree; other factors are pending until the next elimination, and pull on the right-hand
  /// sides of the cliques on the paths of their variables. Returns false, with nothing changed,
  /// where that cannot be done, and where pending factors have cost `share` of what the last
  /// elimination has cost. With `charts`, new factors are linearised about the estimates.
  bool defer(double share, const Charts* charts = nullptr) {
    if (!system_.only_grows() || cliques_.count() == 0) return false;
    if (!(pending_.rent() < share * pending_.price())) return false;
    return hybrid::defer(parts(), charts, workspace_);
  }
  /// Factors that are in the solution and not eliminated yet.
  int pending() const { return pending_.factors(); }

  /// Applies the changes. `last` lists variables to be eliminated last, e.g. the newest pose, and
  /// `behind` those to be eliminated even after these. If pivots were lifted, the system is
  /// singular unless `is_determined` returns true for their variables. With `charts`, all factors
  /// of factors_to_assemble() are linearised about the estimates, and the steps of the variables
  /// that are eliminated begin at zero.
  EliminationReport eliminate(const std::vector<int>& last, const IsDetermined& is_determined = {},
                              const std::vector<int>& behind = {}, const Charts* charts = nullptr) {
    return hybrid::eliminate(parts(), charts, workspace_, {last, behind}, is_determined);
  }

  /// Back-substitutes in the cliques made since the last call, in those with overridden steps, and
  /// downwards in all whose separator changed, unless all of that would lower the linearised
  /// objective by no more than a whole tree may be bent. A clique keeps its steps unless new ones
  /// lower the linearised objective by more than `threshold`; a clique and all below it keep them
  /// where that costs no more than `bend`, by what the factors there say of the separator, and in
  /// all no more than half of what the new steps bring. With `charts`, subtrees without a variable
  /// that is held in the map move as their separators do, and estimates are set. Returns the
  /// variables whose step changed.
  std::vector<int> solve(double threshold, const Bend& bend = {}, Charts* charts = nullptr) {
    back_substitute(parts(), charts, threshold, bend);
    return system_.take_moved();
  }

  /// Covariances in tangents at the estimates, if there are charts.
  TreeCovariances covariances(const Charts* charts = nullptr) const {
    return {system_, cliques_, pending_, charts};
  }
  /// log det of the information matrix.
  double log_determinant() const { return cliques_.log_determinant() + pending_.log_determinant(); }

  /// Makes all changes so far permanent.
  void commit() noexcept {
    system_.commit();
    cliques_.commit();
    pending_.commit();
  }
  /// The present state, to go back to until the next commit or the roll-back to an earlier one.
  /// Nothing is to be eliminated.
  struct Mark {
    LinearSystem::Mark system;
    Cliques::Mark cliques;
    PendingRows::Mark pending;
  };
  Mark mark() { return {system_.mark(), cliques_.mark(), pending_.mark()}; }
  void roll_back(const Mark& mark) noexcept {
    system_.roll_back(mark.system);
    cliques_.roll_back(mark.cliques, system_);
    pending_.roll_back(mark.pending, cliques_, system_);
  }

  std::size_t bytes() const {
    return system_.bytes() + cliques_.bytes() + pending_.bytes() +
           workspace_.places.capacity() * sizeof(EliminationWorkspace::Place);
  }

 private:
  TreeParts parts() { return {system_, cliques_, pending_}; }

  LinearSystem system_;
  Cliques cliques_;
  PendingRows pending_;
  EliminationWorkspace workspace_;
};

}  // namespace hybrid
