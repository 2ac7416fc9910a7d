// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, the hybrid mapping authors
#pragma once

#include <cmath>

namespace hybrid::detail {

/// Whether a squared norm is 1, but for the rounding of some thousand compositions.
inline bool is_unit(double squared_norm) {
  return std::abs(squared_norm - 1.0) <= 1e-12;
}

/// Scales a vector to unit norm: near it by one step of Newton's method, whose error is 3/8 of the
/// squared deviation, elsewhere by division without overflow. A zero vector becomes not a number.
template <class Vector>
void normalize(Vector& v) {
  const double s = v.squaredNorm();
  if (std::abs(s - 1.0) < 1e-8) {
    v *= 0.5 * (3.0 - s);
  } else {
    v /= v.cwiseAbs().maxCoeff();
    v /= v.norm();
  }
}

}  // namespace hybrid::detail
