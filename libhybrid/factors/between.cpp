// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, the hybrid mapping authors
#include "libhybrid/factors/between.h"

namespace hybrid {

BetweenSE2::Residual BetweenSE2::evaluate(const SE2& a, const SE2& b, Jacobian<SE2>* Ja,
                                          Jacobian<SE2>* Jb) const {
  const SE2 h = a.between(b);
  const SO2 to_measured = measured_.rotation().inverse();
  const SO2 angle_error = to_measured * h.rotation();
  const Eigen::Vector2d t = to_measured * (h.translation() - measured_.translation());
  const Residual e(t.x(), t.y(), angle_error.angle());
  if (Ja != nullptr) {
    // Filled entry by entry: 2 x 2 blocks would be stored in parts and then loaded whole, which
    // stalls.
    const double c = to_measured.cos();
    const double s = to_measured.sin();
    *Ja << -c, s, c * h.y() + s * h.x(),  //
        -s, -c, s * h.y() - c * h.x(),    //
        0.0, 0.0, -1.0;
    *Jb << angle_error.cos(), -angle_error.sin(), 0.0,  //
        angle_error.sin(), angle_error.cos(), 0.0,      //
        0.0, 0.0, 1.0;
  }
  return e;
}

}  // namespace hybrid
