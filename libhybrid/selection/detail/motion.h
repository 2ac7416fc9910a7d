// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, the hybrid mapping authors
#pragma once

#include <array>

#include "libhybrid/factors/factor.h"
#include "libhybrid/selection/evidence.h"

namespace hybrid {

/// A motion and the covariance of its right perturbation.
template <class Pose>
struct Motion {
  using Matrix = typename Pose::Jacobian;

  Pose mean;
  Matrix covariance = Matrix::Zero();

  Motion inverse() const {
    const Matrix adjoint = mean.adjoint();
    return {mean.inverse(), adjoint * covariance * adjoint.transpose()};
  }
  friend Motion operator*(const Motion& a, const Motion& b) {
    const Matrix adjoint = b.mean.inverse().adjoint();
    return {a.mean * b.mean, adjoint * a.covariance * adjoint.transpose() + b.covariance};
  }
};

/// The log evidence for a closure if its first pose moves to its second by `predicted`.
template <class Pose>
double evidence_for(const ContinuousFactor& closure, const Motion<Pose>& predicted,
                    const EvidenceModel& model) {
  std::array<double, Pose::kSize> from{}, to{};
  Pose().store(from.data());
  predicted.mean.store(to.data());
  const std::array<const double*, 2> x = {from.data(), to.data()};
  Eigen::VectorXd b(closure.rows());
  Eigen::MatrixXd J(closure.rows(), closure.cols());
  closure.linearize(x.data(), b.data(), J.data());
  const auto of_to = J.rightCols(Pose::kDim);
  const Eigen::MatrixXd S = Eigen::MatrixXd::Identity(closure.rows(), closure.rows()) +
                            of_to * predicted.covariance * of_to.transpose();
  return model.log_ratio(b, S, closure);
}

}  // namespace hybrid
