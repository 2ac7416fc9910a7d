// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, the hybrid mapping authors
#pragma once

#include <vector>

#include "libhybrid/linear/tree/cliques.h"

namespace HYBRID_API hybrid {

/// A motion of the map that a subtree can follow.
struct CliqueMotion {
  MapMotion newest{};  ///< since the last solution
  MapMotion in_all{};  ///< since the chart was made
};

/// Finds the motion of the map after which a clique sees its separator as it has seen it. Returns
/// false where the clique is held in the map, or sees too little.
bool find_motion(const TreeClique& clique, const Charts& charts, CliqueMotion& motion);

/// The variables of a clique from number `first` on, and how they turn.
struct TurnedVariables {
  const LinearSystem& system;
  const TreeClique& clique;
  const Turn& turn;
  int first = 0;

  int dim(int k) const { return system.dim(clique.variables[k]); }
  int anchor_dim() const { return turn.anchor < 0 ? 0 : dim(turn.anchor); }
  int anchor_row() const {
    int row = 0;
    for (int k = first; k < turn.anchor; ++k) row += dim(k);
    return row;
  }
  /// Visits each as visit(number, first row, dim, own turn, turn by the anchor, null if there is
  /// none).
  template <class Visit>
  void for_each(const Visit& visit) const {
    const int by_dim = anchor_dim();
    const double *own = turn.own.data(), *by = turn.by_anchor.data();
    int row = 0;
    for (int k = first; k < static_cast<int>(clique.variables.size()); ++k) {
      const int dim = this->dim(k);
      visit(k, row, dim, own, dim < by_dim ? by : nullptr);
      own += static_cast<std::ptrdiff_t>(dim) * dim;
      by += static_cast<std::ptrdiff_t>(dim) * by_dim;
      row += dim;
    }
  }
};

/// Takes Schur complements of cliques from their charts to the estimates.
class HessianCarrier {
 public:
  /// That of a clique in tangents at the estimates: an array of the clique, or valid until the next
  /// call. About the estimates it is the same quadratic form of the steps from the points of its
  /// chart, H' = T' H T with T = [turn, steps; 0, 1].
  const double* carry(const LinearSystem& system, const Charts& charts, const TreeClique& clique,
                      Chart chart);

 private:
  void shift(int order);
  void times_turn(const LinearSystem& system, const TreeClique& clique);

  std::vector<double> steps_, square_, product_, carried_;
  Turn turn_;
};

}  // namespace hybrid
