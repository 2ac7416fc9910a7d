// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, the hybrid mapping authors
#pragma once

namespace hybrid::detail {

/// Below this squared tangent an angle is had by `arc_series`, exact to rounding.
inline constexpr double kSmallTangent = 1e-3;

/// atan(t) / t for a small t, given its square.
inline double arc_series(double square) {
  return 1.0 -
         square *
             (1.0 / 3 - square * (1.0 / 5 - square * (1.0 / 7 - square * (1.0 / 9 - square / 11))));
}

}  // namespace hybrid::detail
