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

/// Covariance of J x, x being a pose that is not in the graph yet and the variables `keys` of the
/// graph, in that order. `motion` is the factor from the previous pose to the new one (its last
/// key), with as many rows as the tangent of a pose; or the prior of the new pose, of which nothing
/// in the graph depends. Its variables are in `newest` or in `values`. With r = A da + B db for the
/// linearised motion, db = B^-1 (r - A da).
Eigen::MatrixXd covariance_after_motion(const ContinuousFactor& motion, const Values& newest,
                                        const Values& values, const CovarianceOf& covariance_of,
                                        std::vector<Key> keys, const Eigen::MatrixXd& J);

/// The joint covariance of the new pose and the variables.
Eigen::MatrixXd covariance_after_motion(const ContinuousFactor& motion, const Values& newest,
                                        const Values& values, const CovarianceOf& covariance_of,
                                        const std::vector<Key>& keys);

}  // namespace hybrid
