// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, the hybrid mapping authors
#include "libhybrid/closures/kernel.h"

#include <Eigen/Core>
#include <cmath>
#include <utility>

namespace hybrid {
namespace {

const ContinuousFactor& checked(const ContinuousFactorPtr& factor) {
  if (factor == nullptr) throw Error("a kernel needs a factor, got null");
  return *factor;
}

}  // namespace

KernelFactor::KernelFactor(ContinuousFactorPtr factor, Kernel kernel)
    : ContinuousFactor(checked(factor).keys(), checked(factor).types(), checked(factor).rows()),
      factor_(std::move(factor)),
      kernel_(std::move(kernel)) {}

double KernelFactor::cost(const double* const* x) const {
  return 0.5 * kernel_.value(2.0 * factor_->cost(x));
}

double KernelFactor::linearize(const double* const* x, double* r, double* J) const {
  const double s = 2.0 * factor_->linearize(x, r, J);
  const double root = std::sqrt(kernel_.weight(s));
  Eigen::Map<Eigen::VectorXd>(r, rows()) *= root;
  Eigen::Map<Eigen::MatrixXd>(J, rows(), cols()) *= root;
  return 0.5 * kernel_.value(s);
}

}  // namespace hybrid
