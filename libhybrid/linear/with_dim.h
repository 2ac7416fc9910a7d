// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, the hybrid mapping authors
#pragma once

#include <type_traits>

#include "libhybrid/geometry/eigen.h"

namespace HYBRID_API hybrid {

/// Calls use(n) with n the number as a constant for the dimensions of poses and points, which small
/// products are compiled for, and Eigen::Dynamic for all others.
template <class Use>
void with_dim(int dim, const Use& use) {
  switch (dim) {
    case 2:
      return use(std::integral_constant<int, 2>());
    case 3:
      return use(std::integral_constant<int, 3>());
    case 6:
      return use(std::integral_constant<int, 6>());
    default:
      return use(std::integral_constant<int, Eigen::Dynamic>());
  }
}

}  // namespace hybrid
