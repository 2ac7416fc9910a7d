// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, the hybrid mapping authors
#include "libhybrid/factors/between.h"

namespace hybrid {

BetweenSE2::Residual BetweenSE2::evaluate(const SE2& a, const SE2& b, Jacobian<SE2>* Ja,
                                          Jacobian<SE2>* Jb) const {
  const SE2 h = a.between(b);
  const SO2 to_measured = measured_.rotation().inverse();
  const SO2 angle_error = to_measured * h.rotation();
  Residual e;
  e << to_measured * (h.translation() - measured_.translation()), angle_error.angle();
  if (Ja != nullptr) {
    const Eigen::Matrix2d rotation = to_measured.matrix();
    *Ja << -rotation, rotation * Eigen::Vector2d(h.y(), -h.x()), 0.0, 0.0, -1.0;
    *Jb << angle_error.matrix(), Eigen::Vector2d::Zero(), 0.0, 0.0, 1.0;
  }
  return e;
}

}  // namespace hybrid
