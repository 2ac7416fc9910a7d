// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, the hybrid mapping authors
#pragma once

#include <Eigen/Core>
#include <array>
#include <functional>
#include <unordered_map>
#include <vector>

#include "libhybrid/hybrid/graph.h"
#include "libhybrid/linear/bayes_tree.h"
#include "libhybrid/smoother/cost_sum.h"
#include "libhybrid/smoother/discrete_half.h"
#include "libhybrid/smoother/journaled_values.h"
#include "libhybrid/smoother/map_kind.h"
#include "libhybrid/smoother/report.h"
#include "libhybrid/smoother/terms.h"

namespace HYBRID_API hybrid {

struct SmootherOptions {
  /// A factor is linearised again when its linear model is off by more than this, in units of the
  /// objective. It is a measure of what linearisation costs, whatever the units,
  /// the noise or the geometry of a factor.
  double relinearize = 3e-3;
  /// Steps are propagated down the tree while a clique lowers the linearised objective by more than
  /// this.
  double wildfire = 1e-5;
  /// What is below a clique stays, moved with the map above it, where keeping it as it is raises
  /// the objective by no more than this.
  double bend = 1e-3;
  /// The same as a share of what its factors cost: each counts with the mean cost of all, at most
  /// with 1, which noise as stated comes to. So estimates are off by no more than a small share of
  /// what noise leaves them off by, however many there are.
  double bend_share = 1e-3;
  /// Alternation rounds per update (eq. 8): continuous half-steps, each followed by a discrete one.
  /// There is a further one where something flipped, or where the linear models that are to be made
  /// again are off by more than one unit of the objective in all.
  int rounds = 3;
  /// This many of the newest poses are kept near the root, where the next measurements touch the
  /// tree.
  int recent = 10;
  /// Smaller tables than those of a batch, so that an update takes milliseconds where many
  /// decisions hang together: beyond them it improves by local search.
  DiscreteOptions discrete{{std::size_t{1} << 16, std::size_t{1} << 20}};
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
  /// are not finite, mismatched types) throws Error, a singular system gives a status; either way
  /// the smoother is as it was before, and a transaction under way is rolled back, to its newest
  /// mark if it has one.
  UpdateReport update(const Delta& delta);

  /// Relinearises everything and alternates until the relative decrease of the objective is below
  /// `tolerance` and no discrete variable flips, or for `max_rounds`. The tolerance is one of the
  /// objective, not of variables: near its minimum, an objective of L that is right to 1e-10 L has
  /// variables within some sqrt(2e-10 L) of their standard deviations, 4e-4 for L = 1000.
  UpdateReport converge(int max_rounds = 50, double tolerance = 1e-10);

  /// Goes on where the last update has stopped, at the cost of what still moves, with a hundredth
  /// of what updates may leave undone, until an update flips nothing and lowers the objective by
  /// less than 0.01. What nothing touches stays as it is, unlike in `converge`.
  UpdateReport settle(int max_updates = 50);

  /// Begins a transaction: updates until `commit` can be rolled back together, at the cost of what
  /// they touched. Throws Error where one is under way. A variable removed in a transaction cannot
  /// enter again before its end.
  void begin();
  /// Throws Error where no transaction is under way, e.g. since an update was rolled back.
  void commit();
  /// Does nothing where no transaction is under way.
  void roll_back();
  bool in_transaction() const { return in_transaction_; }

  /// Marks the present state within a transaction, to go back to alone: a savepoint. An update that
  /// fails after that rolls back to the newest mark, which is gone then. Returns the number of
  /// marks. Throws Error where no transaction is under way.
  std::size_t mark();
  /// Keeps what came since the mark of that number, and forgets it and those after it. Throws Error
  /// where it is gone.
  void release(std::size_t mark);
  /// Goes back to it, and forgets it and those after it. Does nothing where it is gone.
  void roll_back_to(std::size_t mark) noexcept;

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

  const HybridGraph& graph() const { return graph_; }
  const Values& values() const { return estimate_.get(); }
  const Assignment& assignment() const { return discrete_.assignment(); }
  Estimate estimate() const { return {values(), assignment()}; }
  /// Joint negative log posterior of eq. 6 at the estimate.
  double objective() const { return term_cost_.value() + discrete_.pure_cost(); }
  /// Half the weighted squared error of the continuous factors and the chosen components.
  double cost() const;

  /// Objective less cost: normalisers, weights and discrete factors.
  double constant() const { return term_constant_.value() + discrete_.pure_cost(); }

  /// Joint covariance of continuous variables in the given order (eq. 11b, Laplace), in time
  /// proportional to their paths in the tree; where a weak component with a factor is chosen, which
  /// the tree leaves out, at the cost of a batch factorisation.
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
  std::vector<const Table*> component(Key key) const { return discrete_.component(key); }

  /// Handles of the factors that hold a continuous variable.
  std::vector<Handle> factors_of(Key key) const;

  struct Memory {
    std::size_t bytes = 0;
    double bytes_per_variable = 0.0;
  };
  Memory memory() const;
  const BayesTree& tree() const { return tree_; }
  /// The variables in the elimination order of the Bayes tree.
  std::vector<Key> elimination_order() const;
  const SmootherOptions& options() const { return options_; }

 private:
  /// Small things as they were before the first change since the last commit, or at a mark.
  struct Small {
    CostSum term_cost, term_constant;
    std::vector<int> off, stale, last;
    MapKind map_kind;
    std::vector<Key> recent, kept_last;
    bool weak_left_out = false, couple_weak = false;
  };
  struct Mark {
    Small small;
    BayesTree::Mark tree;
    Terms::Mark terms;
    DiscreteHalf::Mark discrete;
    JournaledValues::Mark values;
    std::size_t graph_changes = 0, lost = 0;
  };
  struct Place {  // where some variables are
    std::vector<int> slots;
    std::vector<double> numbers;
  };
  class MapOf;
  struct GraphChange {  // in the order in which they were made
    HybridGraph::Removed factor;
    bool added = false;
    int number = -1;  // of a term or table that had the place of an added factor before
  };

  // check.cpp
  void check(const Delta& delta) const;
  void check_discrete(const std::vector<DiscreteKey>& keys, const Delta& delta,
                      std::unordered_map<Key, int>& cardinality) const;
  void check_removals(const Delta& delta) const;

  // staging.cpp
  void stage(const Delta& delta, UpdateReport& report);
  void remove_factor(Handle handle);
  void add_variable(Key key, const Values& initial);
  void note_map_kind(VariableType type);
  template <class Factor>
  Handle add_to_graph(Factor factor);
  int add_term(Term term, UpdateReport& report);
  void enter_new_terms(const AddedHandles& handles);
  int& number_of(Handle handle) { return numbers_[static_cast<int>(handle.kind)][handle.index]; }
  int term_of(Handle handle) const { return numbers_[static_cast<int>(handle.kind)][handle.index]; }
  void start_change();
  void make_permanent() noexcept;
  Small small() const;
  void restore(Small&& before) noexcept;
  void undo_graph_changes(std::size_t first) noexcept;
  void undo_failed() noexcept;
  void take_back() noexcept;
  void end_change() noexcept;

  /// What a half-step may leave undone, in units of the objective.
  struct Leeway {
    double relinearize = 0.0, wildfire = 0.0, bend = 0.0, bend_share = 0.0;  ///< see the options
    double minor = 0.0;  ///< not worth damped steps
  };

  // incremental.cpp
  Leeway usual_leeway() const;
  UpdateReport update(const Delta& delta, const Leeway& leeway);
  template <class Change>
  UpdateReport all_or_nothing(const Change& change);
  void alternate(UpdateReport& report);
  bool renew_models(UpdateReport& report);
  void make_models_again(const std::vector<int>& terms, UpdateReport& report);
  void linearize_eliminated();
  void list_changed(UpdateReport& report) const;
  bool eliminate(UpdateReport& report);
  bool discrete_step(UpdateReport& report);
  bool take_flips(UpdateReport& report);
  void set_component(int t, const Component& component);
  void choose_components(Key key);
  void refresh_tables();
  void enter_tree(int t);
  void own_factor(int factor, int t);
  void leave_tree(int t);
  void take_out_of_tree(int t);
  void enter_pulls();
  void record(UpdateReport& report) const { report.objectives.push_back(objective()); }

  // weak_components.cpp
  bool belongs_in_tree(const Component& component) const;
  bool tree_is_whole() const;
  void enter_left_out();
  bool eliminate_new(UpdateReport& report);

  // determination.cpp
  bool is_determined(const std::vector<int>& slots) const;
  bool new_variables_are_determined(const std::vector<Key>& keys) const;
  bool others_say_what_was_lost() const;
  bool others_say_what_was_lost(int most_dims) const;

  // continuous_half.cpp
  void continuous_step(UpdateReport& report);
  void solve(const Leeway& leeway);
  Bend bend_of(const Leeway& leeway) const;
  void touch_untied();
  void refresh_costs();
  void touch(const std::vector<int>& slots);
  void refresh_costs(const std::vector<int>& slots);
  double model_cost(const Term& term) const;
  void fetch_ahead(std::size_t k) const;
  void choose_off();

  // trust_region.cpp
  bool falls_short(double gained, double promised) const;
  Place place_of(std::vector<int> slots) const;
  Place with(const Place& place, const Place& others) const;
  void go_to(const Place& place, UpdateReport& report);
  std::vector<double> way_from(const Place& start) const;
  void go_along(const Place& start, const std::vector<double>& way, double share);
  void go_part_of_the_way(const Place& start, double before);
  void fall_back(double before, double promised, UpdateReport& report);
  void damped_steps(const Place& start, UpdateReport& report);
  void damp(const std::vector<int>& slots, double damping);
  void undamp();
  std::vector<double> own_information(int slot) const;

  SmootherOptions options_;
  HybridGraph graph_;
  JournaledValues estimate_;
  BayesTree tree_;
  Terms terms_;
  DiscreteHalf discrete_;
  std::array<std::vector<int>, 3> numbers_;  // of terms, tables, terms: by kind and index of handle
  std::vector<int> table_of_term_;
  CostSum term_cost_;           // over terms
  CostSum term_constant_;       // the part of it that does not depend on the variables
  bool weak_left_out_ = false;  // whether a weak component was ever left out of the tree
  bool couple_weak_ = false;    // since a variable hung on one: none is any more
  std::vector<Key> recent_;
  std::vector<Key> kept_last_;
  MapKind map_kind_;
  std::vector<int> off_;    // terms to linearise again in the next update
  double open_ = 0.0;       // by which their linear models are off
  std::vector<int> stale_;  // hybrid terms whose variables moved since their tables were made
  std::vector<int> last_;   // slots to eliminate last, as of the last update

  bool in_transaction_ = false;
  bool changing_ = false;
  Small committed_;
  std::vector<Mark> marks_;
  std::vector<GraphChange> graph_changes_;  // since the last commit
  struct Lost {                             // a factor that has left the tree since then
    const ContinuousFactor* factor = nullptr;
    std::vector<int> slots;  // of its variables
  };
  std::vector<Lost> lost_;

  // Scratch of an update.
  Leeway leeway_;
  std::vector<int> behind_;                // slots to eliminate behind even the last ones
  std::vector<int> changed_;               // slots whose estimate moved in the last continuous step
  std::vector<DiscreteHalf::Flip> flips_;  // of the last discrete step
  std::vector<int> touched_;               // terms listed last
  std::vector<std::pair<double, int>>
      errors_;                       // of linear models, and the terms, at the last refresh
  Place old_;                        // what the half-step under way has moved, before it
  double model_error_ = 0.0;         // by which costs rose more than their models at that refresh
  std::vector<int> damped_;          // slots whose steps are damped
  std::vector<int> damping_factor_;  // in the tree, by slot; -1 for none
  std::vector<int> term_of_factor_;  // by factor of the tree; -1 for damping
  std::vector<unsigned> term_stamp_, slot_stamp_;
  unsigned stamp_ = 0;
  unsigned old_stamp_ = 0;
};

}  // namespace hybrid
