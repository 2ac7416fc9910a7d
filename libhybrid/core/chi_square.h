// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, the hybrid mapping authors
#pragma once

#include "libhybrid/export.h"

namespace HYBRID_API hybrid {

/// Probability that the sum of `degrees` squared standard normal numbers is at most x. Throws Error
/// for degrees below 1 or an x that is not a number.
double chi_square_probability(double x, int degrees);

/// The x with chi_square_probability(x, degrees) = probability: the usual gate of a squared
/// whitened norm. Throws Error unless the probability is in [0, 1) and degrees are at least 1.
double chi_square_quantile(double probability, int degrees);

}  // namespace hybrid
