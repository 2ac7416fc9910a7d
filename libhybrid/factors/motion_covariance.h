// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, the hybrid mapping authors

#pragma once

#include <Eigen/Core>
#include <functional>
#include <vector>

#include "libhybrid/core/values.h"
#include "libhybrid/factors/factor.h"

namespace HYBRID_API hybrid {

/// Joint covariance of a pose that is not in the graph yet and of the variables `keys` of the
/// graph, in that order. `motion` is the factor from the previous pose to the new one (its last
/// key), with as many rows as the tangent of a pose; or the prior of the new pose, and then the
/// covariance of that pose alone is returned. Its variables are in `newest` or in `values`.
/// `joint_covariance` returns the joint covariance of variables of the graph. With r = A da + B db
/// for the linearised motion, db = B^-1 (r - A da).
Eigen::MatrixXd covariance_after_motion(
    const ContinuousFactor& motion, const Values& newest, const Values& values,
    const std::function<Eigen::MatrixXd(const std::vector<Key>&)>& joint_covariance,
    std::vector<Key> keys);

}  // namespace hybrid
