// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, the hybrid mapping authors
#pragma once

#include <string>

#include "libhybrid/closures/closure_problem.h"
#include "libhybrid/core/key_letters.h"

namespace HYBRID_API hybrid {

struct SwitchableOptions : ComparisonOptions {
  double phi = 1.0;  ///< 1 / variance of the prior that holds a switch at one
};

/// A closure times a switch: residual s r(x) over the variables of the closure and a real switch s
/// (Suenderhauf and Protzel, 2012, eq. 6, with the linear switch function).
class SwitchedFactor : public ContinuousFactor {
 public:
  SwitchedFactor(ContinuousFactorPtr factor, Key switch_key);

  double cost(const double* const* x) const override;
  double linearize(const double* const* x, double* r, double* J) const override;
  double log_normalizer() const override { return factor_->log_normalizer(); }
  std::string name() const override { return "switched " + factor_->name(); }
  using ContinuousFactor::cost;

 private:
  ContinuousFactorPtr factor_;
};

/// The switch that minimises s^2 chi2 + phi (1 - s)^2, phi / (phi + chi2): twice this switch, at
/// most one, is the scale of dynamic covariance scaling.
double best_switch(double chi_square, double phi);

/// The name of the switch of a closure.
inline Key real_switch(std::size_t closure) {
  return {key_letter::kClosureWeight, closure};
}

/// Switchable constraints: switches are variables beside the poses, each with a prior at one, which
/// is its initial value. Closures whose final switch is at least one half are accepted; the values
/// returned hold no switches. Throws Error unless phi is positive.
RobustResult solve_switchable(const RobustProblem& problem, const SwitchableOptions& options = {});

}  // namespace hybrid
