// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, the hybrid mapping authors

#pragma once

#include <Eigen/Core>
#include <functional>
#include <vector>

#include "libhybrid/core/values.h"
#include "libhybrid/factors/factor.h"

namespace HYBRID_API hybrid {

/// The covariance of J x, with x the tangents of some variables of a graph stacked.
using CovarianceOf =
    std::function<Eigen::MatrixXd(const std::vector<Key>& keys, const Eigen::MatrixXd& J)>;

/// Covariances of a pose that is not in the graph yet, together with variables of the graph.
/// `motion` is the factor that leads to the pose, with as many rows as the tangent of a pose: from
/// the previous pose, with or without a calibration; or the prior of the pose, of which nothing in
/// the graph depends. With r = A da + B db for the linearised motion, db = B^-1 (r - A da).
class MotionCovariance {
 public:
  /// `newest` has the pose; a further variable of the motion that only `newest` has counts as
  /// known. `values` are those of the graph, and must outlive this.
  MotionCovariance(const ContinuousFactor& motion, Key pose, const Values& newest,
                   const Values& values, CovarianceOf covariance_of);

  /// The covariance of J x, x being the tangents of the pose and of the variables, in that order.
  Eigen::MatrixXd operator()(std::vector<Key> keys, const Eigen::MatrixXd& J) const;
  /// The joint covariance of the pose and the variables.
  Eigen::MatrixXd operator()(const std::vector<Key>& keys) const;

 private:
  const Values* values_;
  CovarianceOf covariance_of_;
  std::vector<Key> from_;    ///< the variables of the graph on which the motion depends
  Eigen::MatrixXd noise_;    ///< B^-1
  Eigen::MatrixXd by_from_;  ///< A
};

}  // namespace hybrid
