// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, the hybrid mapping authors
#include "libhybrid/factors/inflated.h"

#include <Eigen/Core>
#include <cmath>
#include <utility>

#include "libhybrid/core/error.h"

namespace hybrid {
namespace {

const ContinuousFactor& checked(const ContinuousFactorPtr& factor, double variance_factor) {
  if (factor == nullptr) throw Error("no factor to inflate");
  if (!(variance_factor > 0.0) || !std::isfinite(variance_factor)) {
    throw Error("covariance factor must be positive and finite, got " +
                std::to_string(variance_factor));
  }
  return *factor;
}

}  // namespace

Inflated::Inflated(ContinuousFactorPtr factor, double variance_factor)
    : ContinuousFactor(checked(factor, variance_factor).keys(),
                       checked(factor, variance_factor).types(),
                       checked(factor, variance_factor).rows()),
      factor_(std::move(factor)),
      variance_factor_(variance_factor),
      scale_(1.0 / std::sqrt(variance_factor)) {}

double Inflated::cost(const double* const* x) const {
  return factor_->cost(x) / variance_factor_;
}

double Inflated::linearize(const double* const* x, double* r, double* J) const {
  const double cost = factor_->linearize(x, r, J);
  Eigen::Map<Eigen::VectorXd>(r, rows()) *= scale_;
  Eigen::Map<Eigen::VectorXd>(J, rows() * cols()) *= scale_;
  return cost / variance_factor_;
}

double Inflated::log_normalizer() const {
  return factor_->log_normalizer() + 0.5 * rows() * std::log(variance_factor_);
}

std::optional<RelativePose<SE2>> Inflated::relative_pose_2d() const {
  auto motion = factor_->relative_pose_2d();
  if (motion) motion->information /= variance_factor_;
  return motion;
}

std::optional<RelativePose<SE3>> Inflated::relative_pose_3d() const {
  auto motion = factor_->relative_pose_3d();
  if (motion) motion->information /= variance_factor_;
  return motion;
}

}  // namespace hybrid
