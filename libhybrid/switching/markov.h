// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, the hybrid mapping authors
#pragma once

#include <vector>

#include "libhybrid/discrete/table.h"
#include "libhybrid/geometry/eigen.h"

namespace HYBRID_API hybrid {

/// A Markov chain over modes (the discrete states of Fig. 1a).
struct MarkovChain {
  Eigen::VectorXd initial;     ///< p(mode at the start)
  Eigen::MatrixXd transition;  ///< p(next | present), a row per present mode

  int modes() const { return static_cast<int>(initial.size()); }
};

/// Throws Error unless `initial` and every row of `transition` are probabilities that sum to one
/// within 1e-6; the message names the row and its sum.
void check(const MarkovChain& chain);

/// A chain whose modes are equally likely at the start; it stays in its mode with probability
/// `stay`, and changes to all others with equal probabilities. Throws Error for no mode or a `stay`
/// outside [0, 1].
MarkovChain sticky_chain(int modes, double stay);

/// The factors of a chain: a prior of the first variable and a transition between neighbours.
/// Throws Error as `check`, and for a variable whose cardinality is not the number of modes.
std::vector<Table> chain_tables(const MarkovChain& chain, const std::vector<DiscreteKey>& modes);

/// One transition of a chain, for chains that grow.
Table chain_step(const MarkovChain& chain, DiscreteKey from, DiscreteKey to);

/// Counts of starts and changes, whole or expected, from which a chain is learnt.
struct MarkovCounts {
  Eigen::VectorXd starts;
  Eigen::MatrixXd changes;

  explicit MarkovCounts(int modes);
  /// The most probable chain under a Dirichlet prior worth `prior` counts of every start and
  /// change.
  MarkovChain chain(double prior) const;
};

}  // namespace hybrid
