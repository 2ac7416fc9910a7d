// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, the hybrid mapping authors
#pragma once

#include <cmath>
#include <cstdint>
#include <utility>
#include <vector>

#include "libhybrid/export.h"

namespace HYBRID_API hybrid {

enum class ClosureStatus {
  kRejected,   ///< the evidence is against it
  kUndecided,  ///< online: the evidence is for it, but not decisive, or it waits for choices
  kAccepted,
  kTrusted  ///< not in question
};

/// "rejected", "undecided", "accepted" or "trusted".
inline const char* to_string(ClosureStatus status) {
  const char* const texts[] = {"rejected", "undecided", "accepted", "trusted"};
  return texts[static_cast<int>(status)];
}

/// What was decided about one loop closure, and by what.
struct ClosureDecision {
  ClosureStatus status = ClosureStatus::kRejected;
  double inlier_probability = 0.0;  ///< see RobustResult::poses_integrated
  double chi_square = 0.0;          ///< squared whitened residual at the estimate
  /// tr(I - A P A') / d in [0, 1], with A the whitened Jacobian and P the covariance: how far the
  /// other factors can check this one. Near 0, the closure alone determines what it measures.
  double redundancy = 1.0;
  bool checkable = true;  ///< false if the redundancy is too small to tell false from true
  /// Logarithm of the evidence for the closure relative to that for a false one, and the same minus
  /// the threshold of admission; 0 if the method has none.
  double evidence = 0.0, margin = 0.0;
  /// Online, where a program keeps it: indices of the poses at which the status changed, and the
  /// new status.
  std::vector<std::pair<std::uint64_t, ClosureStatus>> history = {};

  static ClosureDecision trusted() { return {ClosureStatus::kTrusted, 1.0}; }

  void accept(bool accepted) {
    status = accepted ? ClosureStatus::kAccepted : ClosureStatus::kRejected;
  }
  bool accepted() const { return status == ClosureStatus::kAccepted; }
  /// Whether its factor is part of the estimate.
  bool in_force() const { return status >= ClosureStatus::kAccepted; }
  /// Norm of the whitened residual.
  double residual() const { return std::sqrt(chi_square); }
  /// The margin as files have it: -1000 where no evidence is enough, since the residual is beyond
  /// every gate.
  double finite_margin() const { return std::isfinite(margin) ? margin : -1e3; }
};

/// Whether each closure was accepted.
inline std::vector<bool> accepted_closures(const std::vector<ClosureDecision>& decisions) {
  std::vector<bool> accepted;
  for (const ClosureDecision& decision : decisions) accepted.push_back(decision.accepted());
  return accepted;
}

}  // namespace hybrid
