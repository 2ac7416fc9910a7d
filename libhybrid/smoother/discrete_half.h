// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, the hybrid mapping authors
#pragma once

#include <cstdint>
#include <optional>
#include <unordered_map>
#include <utility>
#include <vector>

#include "libhybrid/core/assignment.h"
#include "libhybrid/discrete/discrete_tree.h"
#include "libhybrid/discrete/inference.h"
#include "libhybrid/hybrid/graph.h"
#include "libhybrid/linear/free_list.h"
#include "libhybrid/smoother/cost_sum.h"

namespace HYBRID_API hybrid {

/// The discrete half of the smoother: tables by number, and of them only the components that were
/// touched are solved again (eq. 4, 5, 8a), of large ones only the part that follows (see
/// DiscreteTree). A number belongs to a discrete factor (one table) or to
/// a hybrid one (the tables it gives at the present estimate). What happened since the last
/// `commit` can be rolled back; a factor that is removed says nothing any more, and goes with the
/// commit.
class DiscreteHalf {
 public:
  struct Flip {
    Key key;
    int from;
    int to;
  };
  struct Report {
    std::vector<Flip> flips;
    int components = 0;
    int variables = 0;  ///< of these that were looked at, or had their messages made
    bool exact = true;
  };

  /// A factor over the given variables; its tables come with `set_tables`. Variables that are not
  /// known yet start at their value in `initial`, or 0. `owner` is the term of a hybrid factor, or
  /// -1; it may be set before the tables are. Returns the number.
  int add(const std::vector<DiscreteKey>& keys, int owner, const Assignment& initial);
  /// Variables that no factor holds any more are forgotten with the commit.
  void remove(int f);
  /// Replaces the tables of a factor and touches its component.
  void set_tables(int f, std::vector<Table> tables);

  /// Solves the touched components exactly, ties kept, and moves the assignment there.
  Report solve(const DiscreteOptions& options);
  /// Gives a variable another value, e.g. its former one where a flip left the continuous half
  /// singular.
  void move(Key key, int value);

  void commit() noexcept;
  struct Mark {
    std::size_t added = 0, removed = 0, tables = 0, values = 0, numbers = 0;
    CostSum pure_cost;
    std::vector<Key> touched;
  };
  /// The present state, to go back to until the next commit or the roll-back to an earlier one.
  Mark mark();
  void roll_back() noexcept { roll_back(base_); }
  void roll_back(const Mark& mark) noexcept;

  const Assignment& assignment() const { return assignment_; }
  /// Sum of the tables of discrete factors at the assignment.
  double pure_cost() const { return pure_cost_.value(); }
  const std::vector<int>& factors_of(Key key) const { return variables_.at(key).factors; }
  int owner(int f) const { return factors_[f].owner; }
  void set_owner(int f, int owner) { factors_[f].owner = owner; }
  bool contains(Key key) const { return variables_.count(key) != 0; }
  /// Appends the variables of factors added, and those that were moved, since the last commit.
  void list_changed(std::vector<Key>& keys) const;
  /// Throws Error for an unknown variable.
  int cardinality(Key key) const;
  /// The tables of the component that a variable belongs to.
  std::vector<const Table*> component(Key key) const;
  std::size_t bytes() const;

 private:
  struct Variable {
    std::uint64_t number = 0;  // in the order of arrival
    int cardinality = 0;
    bool is_wide = false;  // its message in the tree would be too large
    std::vector<int> factors;
  };
  struct Factor {
    std::vector<DiscreteKey> keys;
    std::vector<Table> tables;
    int owner = -1;
    double cost = 0.0;   // of a discrete factor, at the assignment
    unsigned saved = 0;  // epoch in which its tables were last saved
  };

  std::vector<const Table*> collect(Key start, std::unordered_map<Key, bool>* visited) const;
  std::optional<int> best_single(Key key) const;
  bool is_small(Key key) const;
  struct Pass;
  bool enter_tree(Key key, Pass& pass) const;
  void set(Key key, int value, Pass& pass);
  void solve_whole(Key key, Pass& pass);
  void solve_touched(Key key, Pass& pass);
  void solve_tree(Pass& pass);
  void refresh_cost(int f);
  void touch(Key key);
  void take_out(int f);
  void start_epoch() noexcept;

  std::unordered_map<Key, Variable> variables_;
  std::vector<Factor> factors_;
  FreeList numbers_;
  Assignment assignment_;
  CostSum pure_cost_;
  std::vector<Key> touched_;
  DiscreteTree tree_;  // of large components
  std::uint64_t variables_so_far_ = 0;

  // Since the last commit.
  unsigned epoch_ = 1;
  std::vector<int> added_, removed_;
  std::vector<std::pair<int, std::vector<Table>>> saved_tables_;  // by factor
  std::vector<std::pair<Key, int>> saved_values_;
  Mark base_;  // has room for `touched_`
};

}  // namespace hybrid
