// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, the hybrid mapping authors
#pragma once

#include <vector>

#include "libhybrid/linear/bayes_tree.h"
#include "libhybrid/smoother/terms.h"

namespace HYBRID_API hybrid {

/// Terms and their linear models, which are factors of a Bayes tree. A weak component is kept out
/// of the tree for its fill-in, unless a variable hangs on one. What happened since the last
/// `commit`, or since a mark after it, can be rolled back.
class LinearModels {
 public:
  /// A factor that has left the tree.
  struct Lost {
    const ContinuousFactor* factor = nullptr;
    std::vector<int> slots;  ///< of its variables
  };

  const BayesTree& tree() const { return tree_; }
  BayesTree& tree() { return tree_; }
  const Terms& terms() const { return terms_; }
  Terms& terms() { return terms_; }

  /// Brings a term into the tree, if it belongs there.
  void enter(int t, const Values& values);
  void leave(int t);
  /// Chooses another component of a hybrid term, with its cost at the values. A new linearisation
  /// always goes with it: a stale one would leave the mode right and the pose wrong.
  void choose(int t, const Component& component, const Values& values);
  /// Lets weak components pull at their variables, so that the estimate converges to the exact
  /// optimum.
  void enter_pulls(const Values& values);

  /// Brings weak components into the tree, for good.
  void couple_weak(const Values& values);
  bool weak_are_coupled() const { return weak_.coupled; }
  /// Whether the Hessian of all chosen components (eq. 13) is that of the tree.
  bool is_whole() const;

  /// Adds a factor to the tree that penalises the step of a variable: the Hessian is its caller's.
  int add_penalty(int slot);

  /// Lets the next elimination linearise some terms again; returns how many.
  int make_again(const std::vector<int>& terms);
  /// Linearises what is to be eliminated.
  void linearize_eliminated(const Values& values);

  /// Those that have left the tree since the last commit.
  const std::vector<Lost>& lost() const { return lost_; }

  struct Weak {
    bool left_out = false;  ///< whether one was ever left out of the tree
    bool coupled = false;   ///< since a variable hung on one: none is any more
  };
  struct Mark {
    BayesTree::Mark tree;
    Terms::Mark terms;
    Weak weak;
    std::size_t lost = 0;
  };
  void commit() noexcept;
  Mark mark() { return {tree_.mark(), terms_.mark(), weak_, lost_.size()}; }
  void roll_back(const Mark& mark) noexcept;

 private:
  bool belongs_in_tree(const Component& component) const {
    return component.factor != nullptr && (!component.weak || weak_.coupled);
  }
  void own(int factor, int t);
  void take_out(int t);

  BayesTree tree_;
  Terms terms_;
  std::vector<int> term_of_factor_;  // by factor of the tree; -1 for a penalty
  Weak weak_;
  std::vector<Lost> lost_;
};

}  // namespace hybrid
