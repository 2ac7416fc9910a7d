// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, the hybrid mapping authors
#pragma once

#include <string>

#include "libhybrid/factors/factor_of.h"

namespace hybrid {

/// b = M a + c.
template <int N>
class LinearRelation
    : public FactorOf<N, Eigen::Matrix<double, N, 1>, Eigen::Matrix<double, N, 1>> {
 public:
  using Vector = Eigen::Matrix<double, N, 1>;
  using Matrix = Eigen::Matrix<double, N, N>;
  using Base = FactorOf<N, Vector, Vector>;

  LinearRelation(Key a, Key b, const Matrix& M, const Vector& c, const Noise& noise)
      : Base({a, b}, noise), M_(M), c_(c) {}
  LinearRelation(Key a, Key b, const Matrix& M, const Vector& c, double sigma)
      : LinearRelation(a, b, M, c, Noise::isotropic(N, sigma)) {}

  std::string name() const override { return "linear relation"; }
  typename Base::Residual evaluate(const Vector& a, const Vector& b, Matrix* Ja,
                                   Matrix* Jb) const override {
    if (Ja != nullptr) {
      *Ja = -M_;
      Jb->setIdentity();
    }
    return b - M_ * a - c_;
  }

 private:
  Matrix M_;
  Vector c_;
};

using Scalar = Eigen::Matrix<double, 1, 1>;

/// b = m' a.
template <int N>
class LinearForm : public FactorOf<1, Eigen::Matrix<double, N, 1>, Scalar> {
 public:
  using Vector = Eigen::Matrix<double, N, 1>;
  using Base = FactorOf<1, Vector, Scalar>;

  LinearForm(Key a, Key b, const Vector& m, double sigma)
      : Base({a, b}, Noise::isotropic(1, sigma)), m_(m) {}

  std::string name() const override { return "linear form"; }
  Scalar evaluate(const Vector& a, const Scalar& b, Eigen::Matrix<double, 1, N>* Ja,
                  Scalar* Jb) const override {
    if (Ja != nullptr) {
      *Ja = -m_.transpose();
      Jb->setIdentity();
    }
    return b - m_.transpose() * a;
  }

 private:
  Vector m_;
};

}  // namespace hybrid
