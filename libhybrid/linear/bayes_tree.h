// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, the hybrid mapping authors
#pragma once

#include <cstddef>
#include <functional>
#include <tuple>
#include <utility>
#include <vector>

#include "libhybrid/geometry/eigen.h"
#include "libhybrid/linear/block.h"
#include "libhybrid/linear/charts.h"
#include "libhybrid/linear/elimination.h"
#include "libhybrid/linear/free_list.h"
#include "libhybrid/linear/front.h"
#include "libhybrid/linear/packed.h"
#include "libhybrid/linear/pool.h"

namespace HYBRID_API hybrid {

/// The outcome of an elimination.
struct EliminationReport {
  int variables = 0;  ///< variables eliminated again
  int cliques = 0;    ///< new cliques
  /// -1 for success; otherwise a variable that the system does not determine, or whose pivot is not
  /// finite. In that case the tree is as before, and the changes are still to be eliminated.
  int singular = -1;
};

/// By how much the objective may rise, at most, where a subtree stays as it is or moves as a whole.
struct Bend {
  double whole = 0.0;       ///< whatever is in it
  double per_factor = 0.0;  ///< and for each of its factors
};

/// Returns whether variables whose pivots are lost in rounding are determined all the same.
using IsDetermined = std::function<bool(const std::vector<int>& variables)>;

/// The Bayes tree of a linear least-squares problem min ||J d + r||^2 (Kaess et al., iSAM2): the
/// square-root information matrix as a tree of cliques, updated by re-eliminating only the part
/// that a change touches. Variables and factors are small integers. Changes are collected until
/// `eliminate`. All changes since the last `commit` can be rolled back, at a cost that depends on
/// their extent alone.
///
/// A pivot is the remaining information of a variable's own factors once the variables before it
/// are eliminated. A pivot below kPivotShare of that information is lost in rounding; it is lifted
/// to this share, which holds the present step in a direction that nothing but rounding determines.
class BayesTree {
 public:
  /// Some thousand times the precision of a double: the rounding of sums of so many terms.
  static constexpr double kPivotShare = 1e-12;

  /// Adds a variable with step zero; `v` may be the number of one whose removal was committed.
  void add_variable(int v, int dim);
  /// Removes a variable; its factors must be removed in the same transaction.
  void remove_variable(int v);

  /// Adds a factor with an all-zero Hessian, to be filled in through `hessian`. Returns its number.
  int add_factor(const std::vector<int>& variables);
  /// Adds one that is linearised about so many numbers, to be filled in behind the Hessian.
  int add_factor(const std::vector<int>& variables, int points);
  void remove_factor(int f);
  /// The augmented Hessian [J r]'[J r] of a factor for writing: packed lower triangle, order
  /// hessian_order(f). Marks the factor as changed.
  double* hessian(int f);
  int hessian_order(int f) const { return factors_[f].order; }
  /// The same for reading.
  const double* hessian_of(int f) const { return hessians_.at(factors_[f].hessian); }
  /// The points about which a factor is linearised.
  double* points(int f) {
    return hessians_.at(factors_[f].hessian) + packed_size(factors_[f].order);
  }
  /// These points, and the motion of the clique in which it was assembled since.
  Chart chart_of(int f) const {
    const FactorState& factor = factors_[f];
    return {factor.clique < 0 ? nullptr : cliques_[factor.clique].motion(),
            hessian_of(f) + packed_size(factor.order)};
  }
  /// Makes the next `eliminate` assemble a factor anew.
  void assemble_again(int f) { touch(factors_[f].clique); }

  /// Begins to load what linear_cost(f) needs.
  void prefetch(int f) const;

  /// Sets the step of a variable to zero, after its linearisation point has moved by it.
  void reset_delta(int v);

  /// Makes the next `eliminate` eliminate a variable again, and so order it anew.
  void eliminate_again(int v) { touch(variables_[v].clique); }

  /// The factors that the next `eliminate` assembles, as the changes so far stand: new ones, those
  /// whose Hessian was written, and all in the cliques on the paths from these to the root.
  const std::vector<int>& factors_to_assemble();

  /// Applies the changes. `last` lists variables to be eliminated last, e.g. the newest pose, and
  /// `behind` those to be eliminated even after these. If pivots were lifted, the system is
  /// singular unless `is_determined` returns true for their variables. With `charts`, all factors
  /// of factors_to_assemble() are linearised about the estimates, and the steps of the variables
  /// that are eliminated begin at zero.
  EliminationReport eliminate(const std::vector<int>& last, const IsDetermined& is_determined = {},
                              const std::vector<int>& behind = {}, const Charts* charts = nullptr);

  /// Makes all changes so far permanent.
  void commit() noexcept;
  /// Undoes all changes since the last commit.
  void roll_back() noexcept { roll_back(base_); }
  /// The present state, to go back to until the next commit or the roll-back to an earlier one.
  /// Nothing is to be eliminated.
  struct Mark {
    std::size_t new_variables = 0, removed_variables = 0, new_factors = 0, removed_factors = 0;
    std::size_t retired = 0, born = 0, hessians = 0, deltas = 0, seen = 0;
    std::size_t factor_numbers = 0, clique_numbers = 0;
    std::vector<int> fresh, pending;
    unsigned epoch = 1;  ///< cliques made since then have this one or a later one
  };
  Mark mark();
  void roll_back(const Mark& mark) noexcept;

  /// Back-substitutes in the cliques made since the last call, in those with overridden steps, and
  /// downwards in all whose separator changed. A clique keeps its steps unless new ones lower the
  /// linearised objective by more than `threshold`; a clique and all below it keep them where that
  /// costs no more than `bend`, by what the factors there say of the separator, and in all no more
  /// than half of what the new steps bring. With `charts`,
  /// subtrees without a variable that is held in the map move as their separators do, and estimates
  /// are set. Returns the variables whose step changed.
  const std::vector<int>& solve(double threshold, const Bend& bend = {}, Charts* charts = nullptr);

  /// Half the squared residual that the linear model of a factor predicts at the present steps.
  double linear_cost(int f) const;
  /// The same at given steps of its variables, one after the other.
  double linear_cost(int f, const double* steps) const;

  /// Overrides the step of a variable; its clique is solved again by the next `solve`.
  void set_delta(int v, const double* step);
  /// Sets the step of a variable from its estimate.
  void set_delta(int v, const Charts& charts);

  const double* delta(int v) const { return deltas_.at(variables_[v].delta); }
  int dim(int v) const { return variables_[v].dim; }

  /// Joint covariance of some variables, in their order: forward substitution along their paths to
  /// the root alone.
  Eigen::MatrixXd joint_covariance(const std::vector<int>& variables,
                                   const Charts* charts = nullptr) const;
  /// Covariance J Sigma J' of J x, with x the variables stacked and Sigma their joint covariance,
  /// without computing Sigma: J x may be known to a millimetre where x itself is known to a
  /// kilometre, and Sigma is not precise enough to tell.
  Eigen::MatrixXd joint_covariance(const std::vector<int>& variables, const Eigen::MatrixXd& J,
                                   const Charts* charts = nullptr) const;
  /// Covariances of all variables by one recursion from the roots (Takahashi), visited as
  /// visit(variable, dim x dim covariance).
  void visit_covariances(
      const std::function<void(int variable, const Eigen::MatrixXd& covariance)>& visit,
      const Charts* charts = nullptr) const;

  /// log det of the information matrix.
  double log_determinant() const;
  /// The change of log_determinant() since the last commit, from the cliques replaced since.
  double log_determinant_change() const;

  int clique_count() const { return clique_count_ - static_cast<int>(retired_.size()); }
  /// Entries of the factor L.
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
    unsigned saved = 0;  // epoch in which its step was last saved
  };
  struct FactorState {
    std::vector<int> variables;
    int order = 0;
    int points = 0;  // numbers behind the Hessian
    std::size_t hessian = 0;
    int clique = -1;  // the clique in which it is assembled
    bool alive = false;
    unsigned saved = 0;  // epoch in which its Hessian was last saved
    std::size_t size() const { return packed_size(order) + points; }
  };
  static constexpr std::size_t kMotionSize = std::tuple_size<MapMotion>::value;
  struct Clique {
    int parent = -1;
    std::vector<int> children;
    std::vector<int> variables;  // frontals, then separators
    int frontals = 0;            // how many variables are frontal
    int frontal_dim = 0;
    int order = 0;  // rows of `columns`: frontal, separator, one for the right-hand side
    std::vector<int> factors;
    int factors_below = 0;  // with its own
    Block storage;
    bool detached = false;  // replaced, or being replaced
    bool pending = false;   // its step was overridden: to be solved again
    bool free = false;      // no variable of it or below is held in the map
    bool charted = false;
    unsigned born = 0;          // epoch in which it was made
    unsigned saved = 0;         // epoch in which what it sees was last saved
    unsigned saved_motion = 0;  // or its motion alone
    enum class Visit : char { kNone, kKept, kSolved };
    Visit visit = Visit::kNone;  // in the `solve` under way

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
    double log_pivots() const;  // of the squared diagonal of L
  };
  /// Arrays of numbers as they were at the last commit, concatenated.
  struct Journal {
    std::vector<int> ids;
    std::vector<double> numbers;
    void save(int id, const double* x, std::size_t n) {
      // Both or neither where memory is short: what is last is restored first.
      if (ids.size() == ids.capacity()) ids.reserve(2 * ids.size() + 1);
      numbers.insert(numbers.end(), x, x + n);
      ids.push_back(id);
    }
    /// Writes what was saved since then back to place(id), the last first, of size_of(id) numbers.
    template <class Size, class Place>
    void restore(std::size_t first, const Size& size_of, const Place& place) {
      for (; ids.size() > first; ids.pop_back()) {
        const std::size_t n = size_of(ids.back());
        std::copy_n(numbers.end() - static_cast<std::ptrdiff_t>(n), n, place(ids.back()));
        numbers.resize(numbers.size() - n);
      }
    }
    void clear() {
      ids.clear();
      numbers.clear();
    }
  };
  /// Additions or removals since the last commit; those from `pending` on are not eliminated yet.
  struct Changes {
    std::vector<int> all;
    std::size_t pending = 0;
    void cut(std::size_t count) { pending = (all.resize(count), count); }
    auto begin() const { return all.begin() + static_cast<std::ptrdiff_t>(pending); }
    auto end() const { return all.end(); }
  };

  int new_clique();
  void free_clique(int c) noexcept;
  void release_factor(int f);
  void touch(int clique);
  void save_delta(int v);
  void detach_top();
  void gather_problem();
  void group_problem(const std::vector<int>& last, const std::vector<int>& behind);
  int make_clique(const SymbolicClique& symbolic, const std::vector<int>& made,
                  const Charts* charts);
  void assemble(const Clique& clique, const SymbolicClique& symbolic, const std::vector<int>& made,
                const Charts* charts);
  void assemble_factor(const FactorState& factor, int last);
  void assemble_update(const Clique& child, int last, const Charts* charts);
  void carry_over(const std::vector<int>& variables, int first, Chart chart, const double* hessian,
                  int order, const Charts& charts);
  void shift_carried(int order);
  void times_turn(const std::vector<int>& variables, int first, int order);
  void scatter_update(const Clique& child, const double* update, int last);
  void set_thresholds(const Clique& clique);
  void hold_lifted(const Clique& clique);
  void attach(const std::vector<SymbolicClique>& symbolic, const std::vector<int>& made,
              const Charts* charts);
  void set_free(const std::vector<int>& made, const Charts& charts);
  void refuse(std::size_t first);
  void reset_local();
  void reset_scratch();
  void start_epoch() noexcept;
  void reinstate(int c);
  void restore_numbers(const Mark& mark) noexcept;
  void propagate(std::vector<int>& stack, double threshold, const Bend& bend, Charts* charts);
  double prepare(const Clique& clique, const double* seen);
  void solve_prepared(Clique& clique, Charts* charts);
  double promise(const Charts* charts);
  template <class Rise>
  bool may_bend(const Clique& clique, const std::vector<double>& view, const Bend& bend,
                const Rise& rise);
  double rise_of_staying(int c, const Bend& bend, const Charts* charts);
  bool is_left(int c, const Bend& bend, Charts* charts);
  void see(const Clique& clique, const Charts* charts);
  double strain(const Clique& clique, const std::vector<double>& view) const;
  bool find_motion(const Clique& clique, const Charts& charts);
  bool follow(const Clique& clique, const Charts& charts);
  void move_below(int c, const MapMotion& motion, Charts& charts);
  void save_seen(int c);
  void save_motion(int c);
  void list_changed(const Clique& clique, std::size_t from, std::size_t to);
  bool solve_kept_ancestors(int c, std::vector<int>& stack, Charts* charts);
  void reset_marks();
  std::vector<int> top_down() const;
  std::vector<int> paths_of(const std::vector<int>& variables) const;
  bool look(const Clique& clique, const Charts& charts, Turn& turn) const;
  template <class Visit>
  void for_each_turn(const Clique& clique, const Turn& turn, const Visit& visit) const;
  std::pair<int, int> anchor_rows(const Clique& clique, const Turn& turn) const;
  void turn_frontals(const Clique& clique, const Turn& turn,
                     Eigen::Ref<Eigen::MatrixXd> front) const;
  void turn_separator(const Clique& clique, const Turn& turn, const Eigen::MatrixXd& given,
                      Eigen::Ref<Eigen::MatrixXd> front) const;
  Eigen::MatrixXd rows_of(const Clique& clique, const Charts* charts) const;

  std::vector<VariableState> variables_;
  std::vector<FactorState> factors_;
  FreeList factor_numbers_;
  std::vector<Clique> cliques_;
  FreeList clique_numbers_;
  int clique_count_ = 0;
  Pool hessians_;
  Pool deltas_;
  std::vector<int> fresh_, pending_;  // cliques to solve: new ones, those with overridden steps

  // Since the last commit.
  unsigned epoch_ = 1;
  Changes new_variables_, removed_variables_, new_factors_, removed_factors_;
  std::vector<int> retired_;  // cliques that were replaced
  std::vector<int> born_;     // cliques made, some of them freed again
  Journal saved_hessians_, saved_deltas_;
  Journal saved_seen_;  // what cliques see, and by ~c the motion of clique c alone
  // Its lists have the capacity of the present ones, so that neither a commit nor a roll-back needs
  // memory.
  Mark base_;

  // Scratch of `eliminate` and `solve`.
  std::vector<int> touched_;
  std::vector<int> detached_, orphans_, affected_;
  std::vector<int> local_;     // by variable: index among the affected, or -1
  std::vector<int> offset_;    // by variable: row in the front being assembled
  std::vector<double> scale_;  // by variable: its information in the front being assembled
  Hypergraph problem_;
  std::vector<int> group_;
  std::vector<int> edge_factor_;  // by edge of the problem: its factor, or -1 - orphan
  Front front_;
  std::vector<double> least_;          // least pivots of the front
  std::vector<double> diagonal_;       // of its frontals, before elimination
  std::vector<int> lifted_;            // columns of the front
  std::vector<int> lifted_variables_;  // of the elimination
  std::vector<int> visited_, kept_;    // cliques
  std::vector<int> changed_;
  std::vector<char> changed_mark_;
  double may_rise_ = 0.0;  // by how much the objective may still rise in the `solve` under way
  std::vector<double> step_, rhs_, view_;
  Turn turn_;
  std::vector<double> square_, product_, carried_;  // of the Hessian of a factor or subtree
  struct {
    bool found = false;
    MapMotion motion{}, in_all{};  // since the last solution, and since the chart was made
    std::vector<double> view;
  } follow_;
  std::vector<int> below_, to_assemble_;
};

}  // namespace hybrid
