// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, the hybrid mapping authors
#pragma once

#include <cmath>
#include <string>

#include "libhybrid/factors/factor_of.h"
#include "libhybrid/geometry/se2.h"

namespace hybrid::testing {

/// Rosenbrock's valley as a residual, with minimum zero at (1, 1): Gauss-Newton steps overshoot.
class Valley : public FactorOf<2, Eigen::Vector2d> {
 public:
  explicit Valley(Key key, double steep = 10.0) : FactorOf({key}, Noise::unit(2)), steep_(steep) {}
  std::string name() const override { return "valley"; }
  Residual evaluate(const Eigen::Vector2d& x, Jacobian<Eigen::Vector2d>* J) const override {
    if (J != nullptr) *J << -2.0 * steep_ * x[0], steep_, -1.0, 0.0;
    return {steep_ * (x[1] - x[0] * x[0]), 1.0 - x[0]};
  }

 private:
  double steep_;
};

/// A factor with a Jacobian of the wrong sign, as by a mistake of its author.
class WrongJacobian : public FactorOf<1, Eigen::Vector2d> {
 public:
  explicit WrongJacobian(Key key) : FactorOf({key}, Noise::unit(1)) {}
  std::string name() const override { return "wrong"; }
  Residual evaluate(const Eigen::Vector2d& x, Jacobian<Eigen::Vector2d>* J) const override {
    if (J != nullptr) *J << -1.0, 0.0;
    return Residual(x[0] - 3.0);
  }
};

/// A motion whose residual is always NaN.
class UndefinedMotion : public FactorOf<3, SE2, SE2> {
 public:
  UndefinedMotion(Key a, Key b) : FactorOf({a, b}, Noise::unit(3)) {}
  std::string name() const override { return "undefined"; }
  Residual evaluate(const SE2&, const SE2&, Jacobian<SE2>* Ja, Jacobian<SE2>* Jb) const override {
    if (Ja != nullptr) Ja->setIdentity();
    if (Jb != nullptr) Jb->setIdentity();
    return Residual::Constant(std::nan(""));
  }
};

}  // namespace hybrid::testing
