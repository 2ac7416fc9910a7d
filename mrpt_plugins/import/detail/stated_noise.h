// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, the hybrid mapping authors

#pragma once

#include <cstddef>

#include "libhybrid/geometry/eigen.h"
#include "libhybrid/io/text_row.h"

namespace hybrid {

/// Limits of the standard deviations that imports accept [m, rad]: no sensor is more precise than
/// the lower one, and less precise measurements carry no information.
inline constexpr double kLeastSigma = 1e-9;
inline constexpr double kLargestSigma = 1e6;

/// The standard deviation in word i; throws Error if it is outside these limits.
double stated_sigma(const TextRow& row, std::size_t i);

/// Throws Error with the place of word i unless the covariance is symmetric and positive definite
/// and its standard deviations are within these limits.
void check_covariance(const TextRow& row, std::size_t i, const Eigen::MatrixXd& covariance);

}  // namespace hybrid
