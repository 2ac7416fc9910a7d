// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, the hybrid mapping authors
#pragma once

#include <Eigen/Core>
#include <vector>

#include "libhybrid/factors/factor.h"

namespace hybrid {

/// Which variables of a factor have a place in the map, as the factor itself tells: two or more
/// poses and points that can move together, by any rigid motion, without a change of the residual.
/// A calibration that the factor holds beside them cannot, whatever its type. x points to the
/// variables and J (rows x cols) is the derivative there; all false where the factor holds no pose.
std::vector<bool> located_variables(const ContinuousFactor& factor, const double* const* x,
                                    const Eigen::MatrixXd& J);

}  // namespace hybrid
