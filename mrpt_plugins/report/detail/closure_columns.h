// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, the hybrid mapping authors

#pragma once

#include <vector>

#include "libhybrid/closures/closure_decision.h"
#include "mrpt_plugins/report/columns.h"

namespace hybrid {

/// Closures with the places of their ends and what was decided about each, as columns.
template <class Closure>
nlohmann::ordered_json closure_columns(const std::vector<Closure>& closures) {
  nlohmann::ordered_json out = empty_columns(
      {"i", "j", "decision", "probability", "residual", "redundancy", "margin", "checkable"});
  for (const Closure& closure : closures) {
    const ClosureDecision& decision = closure.decision;
    out["i"].push_back(closure.from);
    out["j"].push_back(closure.to);
    out["decision"].push_back(to_string(decision.status));
    out["probability"].push_back(decimals(decision.inlier_probability, 6));
    out["residual"].push_back(digits(decision.residual()));
    out["redundancy"].push_back(digits(decision.redundancy));
    out["margin"].push_back(digits(decision.finite_margin()));
    out["checkable"].push_back(decision.checkable ? 1 : 0);
  }
  return out;
}

}  // namespace hybrid
