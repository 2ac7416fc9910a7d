// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, the hybrid mapping authors
#pragma once

#include <functional>
#include <vector>

#include "libhybrid/hybrid/graph.h"

namespace HYBRID_API hybrid {

/// How some variables are taken out of a graph without loss of (linearised) information.
struct Marginalization {
  Delta delta;  ///< removes the variables and their factors, adds a prior on the separator
  std::vector<Key> separator;     ///< variables that shared a factor with them, now tied together
  int fill = 0;                   ///< pairs of separator variables that shared no factor before
  std::vector<Key> undetermined;  ///< variables of which the factors leave a direction open
  /// How they move, by their tangents, with the tangents of the separator, given all that is said
  /// of both by the factors that go.
  Eigen::MatrixXd follows;
  /// The information of the factors that go on each of their tangents, all else given.
  Eigen::VectorXd information;
  bool finite = true;  ///< false where a derivative is not: the delta is then not to be used
};

/// Marginalises continuous variables by the Schur complement of their factors, linearised at the
/// estimate: Lambda_SS - Lambda_SM Lambda_MM^-1 Lambda_MS becomes a linear prior on the separator
/// S. Hybrid factors count with their present component; where the component does not depend on the
/// discrete values (a class), what they say about those values stays as a table, else their
/// decision is frozen. Of a discrete variable that `stays`, tied to others by a table as modes in a
/// chain are, what was said stays as a table too, or the chain would change its mind without it.
/// `factors` are the handles of all factors that hold a variable of `keys`.
Marginalization marginalize(
    const HybridGraph& graph, const Values& values, const Assignment& assignment,
    const std::vector<Key>& keys, const std::vector<Handle>& factors,
    const std::function<bool(Key)>& stays = [](Key) { return false; });

}  // namespace hybrid
