// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, the hybrid mapping authors

#pragma once

#include <fmt/format.h>

#include <string>

#include "libhybrid/closures/closure_decision.h"

namespace HYBRID_API hybrid {

/// The columns of a decision in loops.csv.
inline constexpr char kDecisionColumns[] =
    "decision,inlier_probability,residual,redundancy,checkable,margin";

/// The cells of a decision in these columns.
inline std::string decision_cells(const ClosureDecision& decision) {
  return fmt::format("{},{},{},{},{},{}", to_string(decision.status), decision.inlier_probability,
                     decision.residual(), decision.redundancy, decision.checkable ? 1 : 0,
                     decision.finite_margin());
}

}  // namespace hybrid
