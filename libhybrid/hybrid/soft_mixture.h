// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, the hybrid mapping authors
#pragma once

#include <Eigen/Core>
#include <string>
#include <vector>

#include "libhybrid/hybrid/mixture.h"

namespace HYBRID_API hybrid {

/// A mixture with its discrete variable summed out (footnote 4 of the paper):
/// -log f = -T log sum_k exp(-c_k / T), where c_k is -log of component k, normaliser and weight
/// included. At temperature T = 1 that is the sum-mixture; as T falls to zero it becomes the
/// max-mixture min_k c_k.
///
/// Its linearisation is that of the free energy sum_k g_k c_k + T sum_k g_k log g_k at the
/// expectation-maximisation weights g_k, proportional to exp(-c_k / T). The free energy equals -log
/// f at the point of linearisation and bounds it from above elsewhere, so a step that lowers it
/// lowers -log f. The residuals of all components are stacked, each scaled by the root of its
/// weight; one more row, without derivative, adds the difference to the cost.
class SoftMixture : public ContinuousFactor {
 public:
  /// Throws Error if no component has a factor, a weight is not finite, or the temperature is not
  /// positive and finite.
  explicit SoftMixture(std::vector<MixtureComponent> components, double temperature = 1.0);

  double cost(const double* const* x) const override;
  double linearize(const double* const* x, double* r, double* J) const override;
  /// -log of the density with all residuals zero, its upper bound, so that the cost is never
  /// negative.
  double log_normalizer() const override { return log_normalizer_; }
  std::string name() const override { return "soft mixture"; }
  using ContinuousFactor::cost;

  const std::vector<MixtureComponent>& components() const { return components_; }
  double temperature() const { return temperature_; }
  /// The weights g_k at some values: p(component | values) at temperature one.
  Eigen::VectorXd weights(const Values& values) const;

 private:
  double component_cost(std::size_t k, const double* const* x) const;
  Eigen::VectorXd costs(const double* const* x) const;

  std::vector<MixtureComponent> components_;
  std::vector<std::vector<int>> positions_;  // by component, see Component::positions
  std::vector<int> columns_;                 // first column of each variable
  double temperature_;
  double log_normalizer_;
};

}  // namespace hybrid
