// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, the hybrid mapping authors
// What the smoother does about weak components, which it keeps out of the tree for their fill-in.
#include "libhybrid/smoother/incremental.h"

namespace hybrid {

bool IncrementalSmoother::belongs_in_tree(const Component& component) const {
  return component.factor != nullptr && (!component.weak || couple_weak_);
}

/// Whether the Hessian of all chosen components (eq. 13) is that of the tree.
bool IncrementalSmoother::tree_is_whole() const {
  if (!weak_left_out_) return true;
  for (int t = 0; t < terms_.count(); ++t) {
    const Term& term = terms_[t];
    if (term.alive && term.component.factor != nullptr && term.tree_factor < 0) return false;
  }
  return true;
}

/// Brings what was left out into the tree.
void IncrementalSmoother::enter_left_out() {
  for (int t = 0; t < terms_.count(); ++t) {
    const Term& term = terms_[t];
    if (!term.alive || term.component.factor == nullptr || term.tree_factor >= 0) continue;
    leave_tree(t);
    enter_tree(t);
  }
}

/// Eliminates what is new. Where weak components alone determine variables, these enter the tree,
/// for good.
bool IncrementalSmoother::eliminate_new(UpdateReport& report) {
  if (eliminate(report)) return true;
  if (couple_weak_ || tree_is_whole()) return false;
  report.status = UpdateReport::Status::kOk;
  report.message.clear();
  report.under_constrained = Key();
  couple_weak_ = true;
  enter_left_out();
  return eliminate(report);
}

}  // namespace hybrid
