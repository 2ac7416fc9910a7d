// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, the hybrid mapping authors
#pragma once

#include <functional>
#include <string>

#include "libhybrid/factors/factor.h"

namespace HYBRID_API hybrid {

/// A robust cost rho(s) / 2 of the squared whitened norm s, which a baseline gives to a closure.
struct Kernel {
  std::function<double(double)> value;   ///< rho(s)
  std::function<double(double)> weight;  ///< rho'(s), in [0, 1]
};

/// A factor under a kernel: cost rho(s) / 2, residual and Jacobian scaled by the root of the
/// weight.
class KernelFactor : public ContinuousFactor {
 public:
  KernelFactor(ContinuousFactorPtr factor, Kernel kernel);

  double cost(const double* const* x) const override;
  double linearize(const double* const* x, double* r, double* J) const override;
  double log_normalizer() const override { return factor_->log_normalizer(); }
  std::string name() const override { return factor_->name() + " under a kernel"; }
  /// The relative pose of the factor, without the kernel.
  std::optional<RelativePose<SE2>> relative_pose_2d() const override {
    return factor_->relative_pose_2d();
  }
  std::optional<RelativePose<SE3>> relative_pose_3d() const override {
    return factor_->relative_pose_3d();
  }
  using ContinuousFactor::cost;

 private:
  ContinuousFactorPtr factor_;
  Kernel kernel_;
};

}  // namespace hybrid
