// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, the hybrid mapping authors
#pragma once

#include <string>
#include <vector>

#include "libhybrid/hybrid/hybrid_factor.h"

namespace HYBRID_API hybrid {

/// One component of a mixture: its continuous factor (null for a constant hypothesis) and -log of
/// its weight. For a null factor the constant is the whole -log density.
struct MixtureComponent {
  ContinuousFactorPtr factor;
  double constant = 0.0;
  bool weak = false;  ///< see Component::weak
};

/// A mixture selected by discrete variables (eq. 3, 17, 18): one component for each of their joint
/// values, in row-major order. Components may differ in residual, covariance and in the variables
/// they touch.
class Mixture : public HybridFactor {
 public:
  /// Throws Error unless there is one component per joint value, each with a constant that is a
  /// number or +infinity (impossible).
  Mixture(std::vector<DiscreteKey> discrete_keys, std::vector<MixtureComponent> components);

  Component given(const Assignment& assignment) const override;
  std::vector<Table> given(const double* const* x) const override;
  using HybridFactor::given;
  std::string name() const override { return "mixture"; }

  const std::vector<MixtureComponent>& components() const { return components_; }

 private:
  Component component(std::size_t index) const;

  std::vector<MixtureComponent> components_;
  std::vector<std::vector<int>> positions_;  // by component, see Component::positions
};

/// The untrusted measurement of eq. 17: value 0 of `switch_key` is the inlier model, value 1 a
/// constant or wide outlier model, which is weak (see Component::weak) if its variance is more than
/// a million times that of the inlier. Weights are the prior probabilities of the two, positive.
HybridFactorPtr make_outlier_mixture(DiscreteKey switch_key, ContinuousFactorPtr inlier,
                                     ContinuousFactorPtr outlier, double inlier_weight,
                                     double outlier_weight);

}  // namespace hybrid
