// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, the hybrid mapping authors
#pragma once

#include "libhybrid/geometry/eigen.h"

namespace HYBRID_API hybrid {

/// Adds scale * factor factor' to the lower triangle of a matrix. A factor of no columns adds
/// nothing; Eigen's own rankUpdate divides by zero there.
template <class Target, class Factor>
void rank_update(Target&& target, const Factor& factor, typename Factor::Scalar scale) {
  if (factor.cols() == 0) return;
  target.template selfadjointView<Eigen::Lower>().rankUpdate(factor, scale);
}

}  // namespace hybrid
