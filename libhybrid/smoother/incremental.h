// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, the hybrid mapping authors
#pragma once

#include <Eigen/Core>
#include <functional>
#include <vector>

#include "libhybrid/core/option.h"
#include "libhybrid/hybrid/graph.h"
#include "libhybrid/smoother/report.h"
#include "libhybrid/smoother/smoother_state.h"

namespace HYBRID_API hybrid {

struct SmootherOptions {
  double relinearize = 3e-3;
  double wildfire = 1e-5;
  double bend = 1e-3;
  /// Each factor counts at most with 1, which noise as stated comes to. So estimates are off by no
  /// more than a small share of what noise leaves them off by, however many factors there are.
  double bend_share = 1e-3;
  double defer = 1.0;
  /// There is a further one where something flipped, or where the linear models that are to be made
  /// again are off by more than one unit of the objective in all.
  int rounds = 3;
  int recent = 10;
  /// Smaller tables than those of a batch, so that an update takes milliseconds where many
  /// decisions hang together: beyond them it improves by local search.
  DiscreteOptions discrete{{std::size_t{1} << 16, std::size_t{1} << 20}};

  template <class Table>
  static void describe(Table& table) {
    using O = SmootherOptions;
    table.option("relinearize", &O::relinearize, {1e-12, 1e6},
                 "a factor is linearised again once its linear model is off by more than this, in "
                 "units of the objective");
    table.option("wildfire", &O::wildfire, {1e-15, 1e6},
                 "a step is propagated while it lowers the objective by more than this");
    table.option("bend", &O::bend, {0.0, 1e6},
                 "a part of the map is left as it is, or moved as a whole, while that raises the "
                 "objective by no more than this");
    table.option(
        "bend_share", &O::bend_share, kProbability,
        "besides, for each of its factors, by this share of what a factor costs in the mean");
    table.field("defer", &O::defer,
                "new factors, and variables that one of them determines, wait for an elimination "
                "until that has cost this share of one; 0: each update eliminates");
    table.option("rounds", &O::rounds, {1, 1000}, "rounds of the alternation for each update");
    table.field(
        "recent", &O::recent,
        "newest poses that are kept near the root of the tree, where measurements touch it");
    table.field("discrete", &O::discrete, "settings of discrete inference");
  }
};

/// Online alternating minimisation (section IV-B): each update costs what it touches. The
/// continuous half is a Bayes tree with fluid relinearisation, the discrete half solves only
/// components that were touched, and a hybrid factor is linearised again only when its component or
/// its variables have changed. The joint objective of eq. 6 never rises on the graph at hand.
///
/// Every change is all or nothing: whatever throws on the way, bad input, a factor of the user or a
/// lack of memory, the smoother is then as it was before.
///
/// A copy is an independent smoother, at the cost of the whole tree: the two share factors, which
/// nobody changes, and nothing else, and asked for the same they do the same to the last bit. The
/// copy of one in a transaction is in that transaction.
class IncrementalSmoother {
 public:
  explicit IncrementalSmoother(const SmootherOptions& options = {}) : options_(options) {}

  /// Applies a change as a whole. Bad input (unknown or duplicate keys, dead handles, values that
  /// are not finite, mismatched types, tables that allow no joint value) throws Error, a singular
  /// system gives a status; either way the smoother is as it was before, and a transaction under
  /// way is rolled back, to its newest mark if it has one.
  UpdateReport update(const Delta& delta);

  /// Relinearises everything and alternates until the relative decrease of the objective is below
  /// `tolerance` and no discrete variable flips, or for `max_rounds`. The tolerance is one of the
  /// objective, not of variables: near its minimum, an objective of L that is right to 1e-10 L has
  /// variables within some sqrt(2e-10 L) of their standard deviations, 4e-4 for L = 1000. Throws
  /// Error unless it is a number that is not negative.
  UpdateReport converge(int max_rounds = 50, double tolerance = 1e-10);

  /// Goes on where the last update has stopped, at the cost of what still moves, with a hundredth
  /// of what updates may leave undone, until an update flips nothing and lowers the objective by
  /// less than 0.01. What nothing touches stays as it is, unlike in `converge`.
  UpdateReport settle(int max_updates = 50);

  /// Begins a transaction: updates until `commit` can be rolled back together, at the cost of what
  /// they touched. Throws Error where one is under way. A variable removed in a transaction cannot
  /// enter again before its end.
  void begin() { state_.begin(); }
  /// Throws Error where no transaction is under way, e.g. since an update was rolled back.
  void commit();
  /// Does nothing where no transaction is under way.
  void roll_back() {
    if (in_transaction()) state_.roll_back();
  }
  bool in_transaction() const { return state_.in_transaction(); }

  /// Marks the present state within a transaction, to go back to alone: a savepoint. An update that
  /// fails after that rolls back to the newest mark, which is gone then. Returns the number of
  /// marks. Throws Error where no transaction is under way.
  std::size_t mark() { return state_.mark(); }
  /// Keeps what came since the mark of that number, and forgets it and those after it. Throws Error
  /// where it is gone.
  void release(std::size_t mark) { state_.release(mark); }
  /// Goes back to it, and forgets it and those after it. Does nothing where it is gone.
  void roll_back_to(std::size_t mark) noexcept { state_.roll_back_to(mark); }

  /// From now on these variables, known or still to come, are eliminated after all others (the
  /// constrained keys of iSAM2): changes and covariances of them cost little then, wherever they
  /// are in the graph, and the rest of the tree has the fill that this brings. They replace those
  /// named before; by default there are none, and only the newest variables come last.
  UpdateReport keep_last(const std::vector<Key>& keys);

  /// An estimate as numbers: those of the variables one after the other.
  struct Snapshot {
    std::vector<Key> keys;
    std::vector<double> numbers;
  };
  /// The estimate, to go back to by `restore` while no variable has come or gone.
  Snapshot snapshot() const;
  /// Moves the estimate back, whatever that does to the objective; discrete values stay. Throws
  /// Error where the variables are not those of the snapshot.
  UpdateReport restore(const Snapshot& snapshot);
  /// Moves some variables, whatever that does to the objective; discrete values stay. Throws Error
  /// for variables that are not there, or of another type.
  UpdateReport move(const Values& to);

  const HybridGraph& graph() const { return state_.graph(); }
  const Values& values() const { return continuous().values(); }
  const Assignment& assignment() const { return state_.discrete().assignment(); }
  Estimate estimate() const { return {values(), assignment()}; }
  /// Joint negative log posterior of eq. 6 at the estimate.
  double objective() const { return continuous().cost() + state_.discrete().pure_cost(); }
  /// Half the weighted squared error of the continuous factors and the chosen components.
  double cost() const;

  /// Objective less cost: normalisers, weights and discrete factors.
  double constant() const {
    return continuous().costs().constant() + state_.discrete().pure_cost();
  }

  /// Joint covariance of continuous variables in the given order (eq. 11b, Laplace), in time
  /// proportional to their paths in the tree; where a weak component with a factor is chosen, which
  /// the tree leaves out, at the cost of a batch factorisation. It is that of the linear models of
  /// the tree: after an update whose report says that much is `open`, as beyond some hundredths, a
  /// batch at the same estimate can tell several times more or less; after converge() both agree.
  Eigen::MatrixXd joint_covariance(const std::vector<Key>& keys) const;
  /// Covariance of J x with x their tangents at the estimate stacked: precise where x itself is
  /// not, as that of places relative to each other at the end of a long way. There a pose should be
  /// among the keys, even if J does not depend on it: vectors of as many numbers as space has
  /// dimensions count as points, and turn with the first pose.
  Eigen::MatrixXd joint_covariance(const std::vector<Key>& keys, const Eigen::MatrixXd& J) const;
  /// Covariances of all continuous variables; the same holds.
  void visit_covariances(
      const std::function<void(Key key, const Eigen::MatrixXd& covariance)>& visit) const;
  /// Tables of the discrete component of a variable at the present estimate, for exact marginals
  /// (eq. 11a).
  std::vector<const Table*> component(Key key) const { return state_.discrete().component(key); }

  /// Handles of the factors that hold a continuous variable.
  std::vector<Handle> factors_of(Key key) const;

  struct Memory {
    std::size_t bytes = 0;
    double bytes_per_variable = 0.0;
  };
  Memory memory() const;
  const BayesTree& tree() const { return continuous().models().tree(); }
  /// The variables in the elimination order of the Bayes tree.
  std::vector<Key> elimination_order() const;
  const SmootherOptions& options() const { return options_; }

 private:
  Leeway usual_leeway() const;
  UpdateReport update(const Delta& delta, const Leeway& leeway);
  template <class Change>
  UpdateReport all_or_nothing(const Change& change);
  void alternate(UpdateReport& report);
  bool renew_models(UpdateReport& report);
  void continuous_step(UpdateReport& report);
  std::vector<DiscreteHalf::Flip> discrete_step(UpdateReport& report);
  bool take_discrete_step(UpdateReport& report);
  void record(UpdateReport& report) const { report.objectives.push_back(objective()); }
  const ContinuousHalf& continuous() const { return state_.continuous(); }
  ContinuousHalf& continuous() { return state_.continuous(); }

  SmootherOptions options_;
  SmootherState state_;
};

}  // namespace hybrid
