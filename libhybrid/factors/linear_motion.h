// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, the hybrid mapping authors
#pragma once

#include <string>

#include "libhybrid/factors/factor_of.h"

namespace HYBRID_API hybrid {

/// Linear motion of a state, one mode of a switching linear system (Fig. 1a): residual x_b - (F x_a
/// + c), with the process noise.
template <int N>
class LinearMotion : public FactorOf<N, Eigen::Matrix<double, N, 1>, Eigen::Matrix<double, N, 1>> {
 public:
  using Vector = Eigen::Matrix<double, N, 1>;
  using Matrix = Eigen::Matrix<double, N, N>;

  /// Throws Error for an entry that is not finite.
  LinearMotion(Key a, Key b, const Matrix& F, const Vector& c, const Noise& noise, Loss loss = {})
      : FactorOf<N, Vector, Vector>({a, b}, noise, loss), F_(F), c_(c) {
    if (!F.allFinite() || !c.allFinite()) throw Error("a linear motion is not finite");
  }

  std::string name() const override { return "linear motion"; }

  Vector evaluate(const Vector& a, const Vector& b, Matrix* Ja, Matrix* Jb) const override {
    if (Ja != nullptr) *Ja = -F_;
    if (Jb != nullptr) Jb->setIdentity();
    return b - F_ * a - c_;
  }

 private:
  Matrix F_;
  Vector c_;
};

}  // namespace hybrid
