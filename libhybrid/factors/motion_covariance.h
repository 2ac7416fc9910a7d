// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, the hybrid mapping authors

#pragma once

#include <Eigen/Core>
#include <functional>
#include <vector>

#include "libhybrid/core/values.h"
#include "libhybrid/factors/factor.h"

namespace HYBRID_API hybrid {

/// Joint covariance of a pose that is not in the graph yet and of some variables that are, in that
/// order. `motion` ties the new pose, its last key, to the one before, or is its prior; as many
/// rows as the pose has directions. Its variables are in `newest` or in `values`.
/// `joint_covariance` is that of the graph. With r = A da + B db for the linear motion,
/// db = B^-1 (r - A da).
Eigen::MatrixXd covariance_after_motion(
    const ContinuousFactor& motion, const Values& newest, const Values& values,
    const std::function<Eigen::MatrixXd(const std::vector<Key>&)>& joint_covariance,
    std::vector<Key> keys);

}  // namespace hybrid
