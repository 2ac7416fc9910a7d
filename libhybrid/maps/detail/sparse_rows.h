// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, the hybrid mapping authors

#pragma once

#include <vector>

#include "libhybrid/maps/sparse_gaussian.h"

namespace hybrid {

inline constexpr int kFewestGiven = 4;  // landmarks that one is given

/// The landmarks before `i` of a joint covariance by the variance of their place relative to it.
std::vector<int> nearest_to(const Eigen::MatrixXd& covariance, int i, int dim);

/// The density of landmark `i` given the first `given` of `near`.
SparseRow row_of(const Eigen::MatrixXd& covariance, int i, const std::vector<int>& near, int given,
                 int dim);

}  // namespace hybrid
