// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, the hybrid mapping authors
#pragma once

#include "libhybrid/smoother/incremental.h"

namespace HYBRID_API hybrid {

/// A change of the map that may be right, such as two landmarks that become one.
struct Proposal {
  Delta delta;  ///< the change
  /// By how much the objective (eq. 6) may rise once the map has settled. Of a change that leaves
  /// fewer variables, that is what fewer are worth: its log odds and half the chi-square that a
  /// linear model foresees, (E3) of docs/evidence.md.
  double allowed_rise = 0.0;
  /// Where variables that are in the map are put first, before the discrete half-step.
  Values moved = {};
};

/// Makes a change on trial: the map settles, without the change and then with it, and keeps it if
/// the objective has risen by no more than the proposal allows. Else the smoother is as it was
/// before, to the bit, and the report says `kTurnedDown`; its work is that of the trial. The report
/// is that of an update besides: `kSingular` where the change leaves a variable undetermined.
/// Throws Error for bad input, and where the smoother is in a transaction.
UpdateReport propose(IncrementalSmoother& smoother, const Proposal& proposal);

}  // namespace hybrid
