// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, the hybrid mapping authors
#pragma once

#include <algorithm>
#include <cstddef>
#include <functional>
#include <utility>
#include <vector>

#include "libhybrid/hybrid/graph.h"
#include "libhybrid/smoother/journaled_values.h"
#include "libhybrid/smoother/linear_models.h"
#include "libhybrid/smoother/places.h"
#include "libhybrid/smoother/report.h"
#include "libhybrid/smoother/term_costs.h"
#include "libhybrid/smoother/terms.h"

namespace HYBRID_API hybrid {

/// Which variables are eliminated last, near the root of the tree: those of the newest factors and
/// the newest poses, and behind them those that are to be kept last.
class EliminationOrder {
 public:
  void enter_pose(Key key) { recent_.push_back(key); }
  void keep_last(const std::vector<Key>& keys) { kept_ = keys; }

  /// Begins anew with the slots of the variables of new factors, or goes on with them where earlier
  /// ones are still to be eliminated; the newest poses follow.
  void start(const std::vector<int>& slots, bool goes_on, const JournaledValues& values) {
    if (!goes_on) last_.clear();
    last_.insert(last_.end(), slots.begin(), slots.end());
    for (Key key : recent_) {
      if (values->contains(key) && !values.is_removed(key)) last_.push_back(values->slot(key));
    }
  }
  /// Keeps the newest of the poses, so many.
  void forget(int poses) noexcept {
    const auto count = static_cast<std::size_t>(std::max(poses, 0));
    if (recent_.size() > count) recent_.erase(recent_.begin(), recent_.end() - count);
  }

  /// Slots of the last, as of the last start.
  const std::vector<int>& last() const { return last_; }
  /// Slots of those behind them.
  std::vector<int> behind(const Values& values) const {
    std::vector<int> slots;
    for (Key key : kept_) {
      if (values.contains(key)) slots.push_back(values.slot(key));
    }
    return slots;
  }

 private:
  std::vector<Key> recent_, kept_;
  std::vector<int> last_;
};

/// Numbers of terms, each once, in the order in which they came. Beginning anew costs nothing.
class TermList {
 public:
  const std::vector<int>& get() const { return list_; }
  std::size_t size() const { return list_.size(); }

  /// Begins anew with the terms of some variables.
  void start(const std::vector<int>& slots, const Terms& terms) {
    list_.clear();
    ++now_;
    added_.resize(std::max(added_.size(), static_cast<std::size_t>(terms.count())));
    for (int slot : slots) {
      for (int t : terms.of_variable(slot)) add(t);
    }
  }
  bool contains(int t) const { return added_[t] == now_; }
  /// Adds another of the terms.
  void add(int t) {
    if (contains(t)) return;
    added_[t] = now_;
    list_.push_back(t);
  }
  void sort_from(std::size_t first) {
    std::sort(list_.begin() + static_cast<std::ptrdiff_t>(first), list_.end());
  }

 private:
  std::vector<int> list_;
  std::vector<unsigned> added_;  // by term: when it was last added
  unsigned now_ = 0;
};

/// What a half-step may leave undone, in units of the objective, and what it may put off.
struct Leeway {
  double relinearize = 0.0, wildfire = 0.0, bend = 0.0, bend_share = 0.0;  ///< see SmootherOptions
  double minor = 0.0;  ///< not worth damped steps
  double defer = 0.0;  ///< see SmootherOptions
};

/// What the continuous variables are solved for (eq. 8b): the terms are the factors of the graph,
/// with the components that the assignment chooses.
struct Given {
  const HybridGraph& graph;
  const Assignment& assignment;
};

/// The continuous half of the smoother: the estimate, the linear models about it in a Bayes tree,
/// and how it goes from one estimate to the next. What happened since the last `commit`, or since a
/// mark after it, can be rolled back; a variable that is removed goes with the commit.
class ContinuousHalf {
 public:
  const Values& values() const { return estimate_.get(); }
  const JournaledValues& estimate() const { return estimate_; }
  const LinearModels& models() const { return models_; }
  LinearModels& models() { return models_; }
  const Terms& terms() const { return models_.terms(); }
  const TermCosts& costs() const { return costs_; }
  double cost() const { return costs_.value(); }

  void add_variable(Key key, const Values& initial);
  void remove_variable(Key key);
  /// Adds a term with its component; that of a hybrid factor does not enter the tree yet. Returns
  /// its number.
  int add_term(Term term);
  void remove_term(int t);
  /// Brings new terms into the tree that are not there, and from now on eliminates their variables
  /// last.
  void enter_new(const std::vector<int>& terms);
  /// Chooses the component of a hybrid term.
  void choose(int t, const Component& component);
  void keep_last(const std::vector<Key>& keys);
  /// Hybrid terms that came or whose variables have moved since this was asked last, each once.
  std::vector<int> take_stale() { return costs_.take_stale(); }

  const Leeway& leeway() const { return leeway_; }
  void set_leeway(const Leeway& leeway) { leeway_ = leeway; }
  /// Lists anew which models are off, by the leeway.
  void choose_off() { costs_.choose_off(leeway_.relinearize, terms()); }
  /// Lets the next elimination make the models again that are off, or all, or those of the terms of
  /// the variables that the last solution moved.
  void renew_off(UpdateReport& report);
  void renew_all(UpdateReport& report);
  void renew_moved(UpdateReport& report);
  /// Makes the models of these variables again in the next update.
  void leave_off(const std::vector<int>& slots);

  /// Takes what has changed into the solution, by eliminating it where it cannot be put off.
  /// Returns false, with a status, where something is not determined.
  bool eliminate(const Given& given, UpdateReport& report);
  /// The same for what is new. Where weak components alone determine variables, these enter the
  /// tree, for good.
  bool eliminate_new(const Given& given, UpdateReport& report);
  /// Takes the step of the tree.
  void solve(const Leeway& leeway, const Given& given);

  /// Where variables were that solutions have moved, since the last start.
  const Places& moved() const { return moved_.before(); }
  void start_moving() { moved_.start(values().slot_count()); }
  /// Moves the estimate, to be linearised there at the next elimination.
  void go_to(const Places& places, UpdateReport& report);
  /// Moves the estimate to a share of the way from some places; linear models stay.
  void go_along(const Places& start, const std::vector<double>& way, double share);
  /// Moves the estimate, and linearises it there. Returns what `eliminate` does.
  bool jump(const Places& places, const Given& given, UpdateReport& report);

  /// Covariances by the tree, which must be whole: see IncrementalSmoother.
  Eigen::MatrixXd joint_covariance(const std::vector<Key>& keys) const;
  Eigen::MatrixXd joint_covariance(const std::vector<Key>& keys, const Eigen::MatrixXd& J) const;
  void visit_covariances(
      const std::function<void(Key key, const Eigen::MatrixXd& covariance)>& visit) const;
  std::size_t bytes() const;

  struct Mark {
    LinearModels::Mark models;
    JournaledValues::Mark values;
    TermCosts::Mark costs;
    MapKind map_kind;
    EliminationOrder order;
  };
  /// Called before the first change since a commit.
  void start_change() { committed_ = mark(estimate_.start()); }
  /// Goes on with so many of the newest poses among the last variables.
  void commit(int recent) noexcept;
  Mark mark() { return mark(estimate_.mark()); }
  void roll_back() noexcept { roll_back(std::move(committed_)); }
  void roll_back(Mark&& mark) noexcept;

 private:
  void note_map_kind(VariableType type);
  void set(const Places& places);
  std::vector<int> slots_of(const std::vector<Key>& keys) const;
  Bend bend_of(const Leeway& leeway, const HybridGraph& graph) const;
  void touch_untied();
  void refresh_costs();
  void refresh_costs(const std::vector<int>& slots);
  void make_again(const std::vector<int>& terms, UpdateReport& report) {
    report.relinearized += models_.make_again(terms);
  }
  Mark mark(const JournaledValues::Mark& values) {
    return {models_.mark(), values, costs_.mark(), map_kind_, order_};
  }

  JournaledValues estimate_;
  LinearModels models_;
  TermCosts costs_;
  MapKind map_kind_;
  EliminationOrder order_;
  Leeway leeway_;
  std::vector<int> changed_;  // slots whose estimate the last solution moved
  TermList touched_;
  MovedVariables moved_;
  Mark committed_;
};

}  // namespace hybrid
