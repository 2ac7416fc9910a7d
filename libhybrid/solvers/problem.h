// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, the hybrid mapping authors
#pragma once

#include <memory>
#include <unordered_map>
#include <vector>

#include "libhybrid/core/worker_pool.h"
#include "libhybrid/hybrid/graph.h"
#include "libhybrid/linear/extended_cholesky.h"
#include "libhybrid/linear/normal_equations.h"

namespace HYBRID_API hybrid {

/// How solvers treat weak components (see Component::weak).
enum class WeakComponents {
  kUncoupled,  ///< without off-diagonal blocks in the Hessian, so that they cost no fill-in
  kCoupled     ///< treated like all others
};

/// The cost of one continuous factor, and the length of its residual.
struct FactorCost {
  double cost = 0.0;
  int rows = 0;
};

/// The continuous subproblem of eq. 8b, compiled once for a graph: variables become blocks of a
/// flat state, factors rows of one Jacobian buffer. A change of assignment keeps the sparsity and
/// its analysis as long as the chosen components touch the same variables. The graph must outlive
/// the problem and must not change meanwhile.
class Problem {
 public:
  using State = std::vector<double>;

  /// Its variables are those of the factors of the graph. Throws Error if one of them, or a
  /// discrete one, has no value, or if its type is not that of a factor.
  Problem(const HybridGraph& graph, const Values& values, const Assignment& assignment,
          int threads = 0, WeakComponents weak = WeakComponents::kUncoupled,
          Elimination elimination = Elimination::kAutomatic);

  int block_count() const { return static_cast<int>(blocks_.size()); }
  Key key(int block) const { return blocks_[block].key; }
  VariableType type(int block) const { return blocks_[block].type; }
  /// Index of the first number of a variable in a state.
  int offset(int block) const { return blocks_[block].offset; }
  /// Throws Error for a variable that no factor of the graph names.
  int block(Key key) const;

  State load(const Values& values) const;
  void store(const State& state, Values& values) const;
  /// out = state boxplus step, a vector in elimination order.
  void retract(const State& state, const double* step, State& out) const;

  /// Chooses the components. Throws Error for a discrete variable without a value.
  void set_assignment(const Assignment& assignment);

  /// Half the weighted squared error of the factors chosen.
  double cost(const State& state) const;
  /// The cost of each of these factors.
  std::vector<FactorCost> factor_costs(const State& state) const;
  /// The joint objective of eq. 6 minus the cost, for the chosen assignment: log-normalisers,
  /// weights and tables.
  double constant() const { return constant_; }
  /// The tables of the hybrid factors at a state: with the discrete factors of the graph, they are
  /// the discrete subproblem of eq. 8a.
  std::vector<Table> tables(const State& state) const;

  /// Fills residuals and Jacobians; returns the cost.
  double linearize(const State& state);
  /// H and g of the last linearisation.
  void assemble() { system_->assemble(residuals_.data(), jacobians_.data(), *pool_); }
  /// Factorises H + damping * diag(H), see NormalEquations.
  int factorize(double damping) { return system_->factorize(damping, *pool_); }
  /// J'J of the last linearisation in extended precision, with its null space. Throws Error if a
  /// Jacobian is not finite.
  ExtendedCholesky extended_factor() const;
  /// Sum of |J v|^2 over the factors, v in elimination order.
  double curvature(const double* v) const;
  NormalEquations& system() { return *system_; }
  const NormalEquations& system() const { return *system_; }
  /// How often the sparsity was analysed.
  int analyses() const { return analyses_; }
  int threads() const { return pool_->threads(); }

 private:
  struct Block {
    Key key;
    VariableType type;
    int offset = 0;  // in the state
    int slot = 0;    // in the values
  };
  /// A continuous factor of the layout.
  struct Term {
    const ContinuousFactor* factor = nullptr;
    int first = 0;  // its variables are offsets_[first] ..
  };
  struct HybridTerm {
    const HybridFactor* factor = nullptr;
    int first = 0;  // its variables are hybrid_blocks_[first] ..
  };

  void collect_blocks(const Values& values);
  int checked_block(const std::vector<Key>& keys, std::size_t i, VariableType type) const;
  void add_term(const ContinuousFactor& factor, const int* blocks, bool coupled);
  void compile(const Assignment& assignment);
  double term_cost(int t, const State& state) const;
  template <class Function>
  double sum_over_terms(const Function& function) const;

  const HybridGraph* graph_;
  WeakComponents weak_;
  Elimination elimination_;
  std::unique_ptr<WorkerPool> pool_;
  std::vector<Block> blocks_;
  int state_size_ = 0;
  std::unordered_map<Key, int> block_index_;
  std::vector<HybridTerm> hybrid_terms_;
  std::vector<int> hybrid_blocks_;
  double fixed_constant_ = 0.0;  // log-normalisers of the continuous factors
  std::size_t fixed_terms_ = 0;

  std::vector<Term> terms_;
  std::vector<int> offsets_;
  ResidualLayout layout_;
  double constant_ = 0.0;
  std::vector<double> residuals_, jacobians_;
  std::unique_ptr<NormalEquations> system_;
  int analyses_ = 0;
};

}  // namespace hybrid
