// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, the hybrid mapping authors
// Closures of which at most one is true, in the selection in batch.
#include "libhybrid/selection/detail/readmission.h"

namespace hybrid {

/// Whether an alternative to a closure is accepted, or so probable that the closure has to wait.
bool Readmission::is_excluded(std::size_t k) const {
  const Alternatives& alternatives = closure_problem_.alternatives;
  if (alternatives.set_of(k).empty()) return false;
  return alternatives.exclude(k, [this](std::size_t i) { return accepted_[i]; }) ||
         against_alternatives(k, evidence_, alternatives) <= needed(k);
}

/// Of alternatives that agree with these values, leaves those that no other one comes near.
void Readmission::drop_ambiguous(const Values& values) {
  const std::vector<bool> agree = accepted_;
  const double decisive = threshold();
  for (std::size_t k = 0; k < accepted_.size(); ++k) {
    if (!agree[k]) continue;
    const double cost = closure_problem_.closures[k]->cost(values);
    accepted_[k] = !closure_problem_.alternatives.exclude(k, [&](std::size_t i) {
      return closure_problem_.closures[i]->cost(values) < cost + decisive;
    });
  }
}

/// Weighs alternatives to accepted closures as if these were not.
void Readmission::weigh_alternatives() {
  for (std::size_t k = 0; k < accepted_.size(); ++k) {
    if (!accepted_[k]) continue;
    const ContinuousFactor& part = *closure_problem_.closures[k];
    for (const std::size_t other : closure_problem_.alternatives.set_of(k)) {
      if (other == k || accepted_[other]) continue;
      const ContinuousFactor& factor = *closure_problem_.closures[other];
      GivenOthers alone =
          given_others(without(predictor_->predict(factor), predictor_->predict(part),
                               predictor_->cross(factor, part)),
                       false);
      innovation_[other] = std::move(alone.b);
      redundancy_[other] = alone.redundancy;
      weigh(other, alone.S);
    }
  }
}

}  // namespace hybrid
