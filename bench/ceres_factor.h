// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, the hybrid mapping authors
#pragma once

#include <ceres/ceres.h>

#include <utility>

#include "libhybrid/factors/factor.h"

namespace hybrid::bench {

/// One of our factors as a Ceres cost function. It is linearised even if only the residual is
/// needed, which costs Ceres about a hundredth of an iteration. The Jacobian is with respect to the
/// tangent, in the first columns; the Jacobian of Retraction below selects these.
class CeresFactor : public ceres::CostFunction {
 public:
  explicit CeresFactor(ContinuousFactorPtr factor) : factor_(std::move(factor)) {
    set_num_residuals(factor_->rows());
    for (const VariableType& type : factor_->types()) {
      mutable_parameter_block_sizes()->push_back(type.size);
    }
  }

  bool Evaluate(double const* const* x, double* residuals, double** jacobians) const override {
    double jacobian[12 * 24];
    factor_->linearize(x, residuals, jacobian);
    if (jacobians == nullptr) return true;
    const int rows = factor_->rows();
    const double* block = jacobian;
    for (std::size_t i = 0; i < factor_->types().size(); ++i) {
      const VariableType type = factor_->types()[i];
      if (jacobians[i] != nullptr) {
        for (int r = 0; r < rows; ++r) {
          for (int c = 0; c < type.size; ++c) {
            jacobians[i][r * type.size + c] = c < type.dim ? block[c * rows + r] : 0.0;
          }
        }
      }
      block += rows * type.dim;
    }
    return true;
  }

 private:
  ContinuousFactorPtr factor_;
};

class Retraction : public ceres::Manifold {
 public:
  explicit Retraction(VariableType type) : type_(type) {}
  int AmbientSize() const override { return type_.size; }
  int TangentSize() const override { return type_.dim; }
  bool Plus(const double* x, const double* delta, double* out) const override {
    retract(type_, x, delta, out);
    return true;
  }
  bool PlusJacobian(const double*, double* jacobian) const override {
    for (int i = 0; i < type_.size * type_.dim; ++i) {
      jacobian[i] = i / type_.dim == i % type_.dim ? 1.0 : 0.0;
    }
    return true;
  }
  bool Minus(const double* y, const double* x, double* delta) const override {
    local(type_, x, y, delta);
    return true;
  }
  bool MinusJacobian(const double*, double* jacobian) const override {
    for (int i = 0; i < type_.size * type_.dim; ++i) {
      jacobian[i] = i / type_.size == i % type_.size ? 1.0 : 0.0;
    }
    return true;
  }

 private:
  VariableType type_;
};

}  // namespace hybrid::bench
