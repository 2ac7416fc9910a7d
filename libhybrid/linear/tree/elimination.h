// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, the hybrid mapping authors
#pragma once

#include <functional>
#include <vector>

#include "libhybrid/linear/front.h"
#include "libhybrid/linear/tree/pending_rows.h"

namespace HYBRID_API hybrid {

/// Some thousand times the precision of a double: the rounding of sums of so many terms. A pivot is
/// the remaining information of a variable's own factors once the variables before it are
/// eliminated. A pivot below this share of that information is lost in rounding; it is lifted to
/// this share, which holds the present step in a direction that nothing but rounding determines.
inline constexpr double kPivotShare = 1e-12;

/// The outcome of an elimination.
struct EliminationReport {
  int variables = 0;  ///< variables eliminated again
  int cliques = 0;    ///< new cliques
  /// -1 for success; otherwise a variable that the system does not determine, or whose pivot is not
  /// finite. In that case the tree is as before, and the changes are still to be eliminated.
  int singular = -1;
};

/// Returns whether variables whose pivots are lost in rounding are determined all the same.
using IsDetermined = std::function<bool(const std::vector<int>& variables)>;

/// What an elimination leaves to the next one, which need not begin anew.
struct EliminationWorkspace {
  struct Place {
    int local = -1;      ///< index among the variables of the elimination, or -1
    int offset = -1;     ///< row in the front being assembled
    double scale = 0.0;  ///< information in that front
  };
  std::vector<Place> places;  ///< by variable
  Front front;
};

/// Variables to be eliminated last, and those behind even these.
struct LastVariables {
  const std::vector<int>&last, &behind;
};

/// Eliminates the part of a Bayes tree that changes of the system touch: see BayesTree::eliminate.
EliminationReport eliminate(const TreeParts& tree, const Charts* charts,
                            EliminationWorkspace& workspace, const LastVariables& last,
                            const IsDetermined& is_determined);

/// Eliminates a new variable by one new factor, which says nothing of others but where it is beside
/// them: a leaf below a clique that has them all. Returns the leaf, or -1, with nothing changed,
/// where the factor does not determine the variable, says more, or there is no such clique.
int eliminate_leaf(const TreeParts& tree, const Charts* charts, EliminationWorkspace& workspace,
                   int variable, int factor);

}  // namespace hybrid
