// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, the hybrid mapping authors
#pragma once

#include <string>

#include "libhybrid/factors/factor.h"

namespace HYBRID_API hybrid {

/// A factor with the covariance of its noise multiplied by a number: the outlier model of eq. 17
/// for a measurement of any kind.
class Inflated : public ContinuousFactor {
 public:
  /// Throws Error for a null factor, or a variance factor that is not positive and finite.
  Inflated(ContinuousFactorPtr factor, double variance_factor);

  const ContinuousFactorPtr& factor() const { return factor_; }
  double variance_factor() const { return variance_factor_; }
  double cost(const double* const* x) const override;
  double linearize(const double* const* x, double* r, double* J) const override;
  double log_normalizer() const override;
  std::string name() const override { return "inflated " + factor_->name(); }
  /// The relative pose of the factor, with its information divided by the variance factor.
  std::optional<RelativePose<SE2>> relative_pose_2d() const override;
  std::optional<RelativePose<SE3>> relative_pose_3d() const override;
  using ContinuousFactor::cost;

 private:
  ContinuousFactorPtr factor_;
  double variance_factor_;
  double scale_;  // of the residual and the Jacobian
};

}  // namespace hybrid
