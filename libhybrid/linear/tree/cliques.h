// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, the hybrid mapping authors
#pragma once

#include <cstddef>
#include <tuple>
#include <utility>
#include <vector>

#include "libhybrid/linear/block.h"
#include "libhybrid/linear/charts.h"
#include "libhybrid/linear/tree/linear_system.h"

namespace HYBRID_API hybrid {

/// A node of a Bayes tree: the conditional density of its frontal variables given its separator.
struct TreeClique {
  static constexpr std::size_t kMotionSize = std::tuple_size<MapMotion>::value;

  int parent = -1;
  std::vector<int> children;
  std::vector<int> variables;  ///< frontals, then separators
  int frontals = 0;            ///< how many variables are frontal
  int frontal_dim = 0;
  int order = 0;  ///< rows of `columns`: frontal, separator, one for the right-hand side
  std::vector<int> factors;
  int factors_below = 0;  ///< with its own
  Block storage;
  bool detached = false;  ///< replaced, or being replaced
  bool unsolved = false;  ///< its step was overridden: to be solved again
  bool free = false;      ///< no variable of it or below is held in the map
  bool charted = false;
  int pulled = -1;            ///< number of the pull of pending rows on it
  unsigned born = 0;          ///< epoch in which it was made
  unsigned saved = 0;         ///< epoch in which what it sees was last saved, or began
  unsigned saved_motion = 0;  ///< or its motion alone
  enum class Visit : char { kNone, kKept, kSolved };
  Visit visit = Visit::kNone;  ///< in the solution under way

  /// order x frontal_dim: L, with the right-hand side as last row.
  double* columns() { return storage.data(); }
  const double* columns() const { return storage.data(); }
  /// Column k of the packed lower triangle of the Schur complement.
  const double* update(int k) const {
    return packed_column(columns() + static_cast<std::size_t>(order) * frontal_dim,
                         order - frontal_dim, k);
  }
  /// Information of each separator variable (trace) in the factors of the clique and below it.
  const double* scales() const { return update(order - frontal_dim) + order - frontal_dim; }
  int separator_dim() const { return order - 1 - frontal_dim; }
  /// The steps of the separator that the clique and all below it go by.
  double* seen() { return const_cast<double*>(std::as_const(*this).seen()); }
  const double* seen() const { return scales() + variables.size() - frontals; }
  /// What it sees and its motion.
  std::size_t seen_size() const { return separator_dim() + (charted ? kMotionSize : 0); }
  double* motion() { return charted ? seen() + separator_dim() : nullptr; }
  const double* motion() const { return charted ? seen() + separator_dim() : nullptr; }
  Chart chart() const { return {motion(), seen() + seen_size()}; }
};

/// The cliques of a Bayes tree: which there are, how they hang together, and which of them are to
/// be eliminated or solved again.
class Cliques {
 public:
  TreeClique& operator[](int c) { return cliques_[c]; }
  const TreeClique& operator[](int c) const { return cliques_[c]; }
  int count() const { return count_ - static_cast<int>(retired_.size()); }

  /// Cliques from the roots down, parents before children.
  std::vector<int> top_down() const;
  /// Those on the paths of some variables to the root, children before their parents.
  std::vector<int> paths_of(const std::vector<int>& variables, const LinearSystem& system) const;
  /// All variables in elimination order, children before parents.
  std::vector<int> order() const;
  /// Pairs (row, column) of variables with a block in the factor L, row eliminated after column.
  std::vector<std::pair<int, int>> blocks() const;
  /// Entries of L.
  std::size_t factor_size() const;
  /// log det of the information matrix.
  double log_determinant() const;
  std::size_t bytes() const;

  /// Marks some cliques and all their ancestors as detached, and lists them and the subtrees below
  /// them, the orphans.
  void detach(const std::vector<int>& touched);
  const std::vector<int>& detached() const { return detached_; }
  const std::vector<int>& orphans() const { return orphans_; }
  /// Keeps what is detached.
  void keep_detached() {
    for (int c : detached_) cliques_[c].detached = false;
    detached_.clear();
  }
  /// Makes an empty clique.
  int add();
  std::size_t born() const { return born_.size(); }
  /// Takes away those made after there were so many, and keeps what is detached.
  void refuse(std::size_t born) {
    keep_detached();
    for (std::size_t k = born; k < born_.size(); ++k) free(born_[k]);
    born_.resize(born);
  }
  /// Replaces the detached cliques by new ones, which are linked already.
  void replace_detached(const std::vector<int>& made);
  /// Hangs a new clique below another, which stays as it is.
  void add_leaf(int c, int parent);
  std::size_t leaves() const { return leaves_.size(); }
  /// Takes away the leaves that were added after there were so many. Their numbers are not freed.
  void cut_leaves(std::size_t leaves) noexcept;

  /// Cliques to be solved: new ones, and those with overridden steps.
  const std::vector<int>& fresh() const { return fresh_; }
  const std::vector<int>& unsolved() const { return unsolved_; }
  void set_unsolved(int c) {
    if (cliques_[c].unsolved) return;
    unsolved_.push_back(c);
    cliques_[c].unsolved = true;
  }
  void note_solved() {
    fresh_.clear();
    unsolved_.clear();
  }
  /// Saves what a clique sees, and its motion, before they change.
  void save_seen(int c) {
    TreeClique& clique = cliques_[c];
    saved_.save(c, clique.saved, clique.seen(), clique.seen_size());
  }
  /// What moves with the map sees what it has seen: its motion is all that changes.
  void save_motion(int c) {
    TreeClique& clique = cliques_[c];
    if (clique.saved == saved_.epoch()) return;
    saved_.save(~c, clique.saved_motion, clique.motion(), TreeClique::kMotionSize);
  }

  struct Mark {
    std::size_t retired = 0, born = 0, leaves = 0, seen = 0, numbers = 0;
    std::vector<int> fresh, unsolved;
    unsigned epoch = 1;  ///< cliques made since then have this one or a later one
  };
  void commit() noexcept;
  Mark mark() {
    return {retired_.size(), born_.size(), leaves_.size(), saved_.mark(),
            numbers_.mark(), fresh_,       unsolved_,      saved_.epoch()};
  }
  void roll_back(const Mark& mark, LinearSystem& system) noexcept;

 private:
  void free(int c) noexcept;
  void reinstate(int c, LinearSystem& system) noexcept;

  std::vector<TreeClique> cliques_;
  FreeList numbers_;
  int count_ = 0;
  std::vector<int> detached_, orphans_;
  std::vector<int> fresh_, unsolved_;

  // Since the last commit.
  std::vector<int> retired_;                 // cliques that were replaced
  std::vector<int> born_;                    // cliques made, some of them freed again
  std::vector<std::pair<int, int>> leaves_;  // and those of them hung below an older one, and that
  Journal<double> saved_;  // what cliques see, and by ~c the motion of clique c alone
};

}  // namespace hybrid
