// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, the hybrid mapping authors
#pragma once

#include <string>

#include "libhybrid/factors/factor_of.h"

namespace hybrid {

/// A direct measurement z of a variable: residual x boxminus z.
template <class Group>
class Prior : public FactorOf<Variable<Group>::kDim, Group> {
 public:
  using Base = FactorOf<Variable<Group>::kDim, Group>;

  /// Throws Error for a value that is not finite.
  Prior(Key key, const Group& measured, const Noise& noise, Loss loss = {})
      : Base({key}, noise, loss), measured_(measured) {
    check_measurement(*this, measured, "value");
  }

  const Group& measured() const { return measured_; }
  std::string name() const override { return "prior"; }

  typename Base::Residual evaluate(const Group& x,
                                   typename Base::template Jacobian<Group>* J) const override {
    return measured_.between(x).log(J);
  }

 private:
  Group measured_;
};

/// The same for vectors: residual x - z.
template <int N>
class Prior<Eigen::Matrix<double, N, 1>> : public FactorOf<N, Eigen::Matrix<double, N, 1>> {
 public:
  using Vector = Eigen::Matrix<double, N, 1>;

  /// Throws Error for a value that is not finite.
  Prior(Key key, const Vector& measured, const Noise& noise, Loss loss = {})
      : FactorOf<N, Vector>({key}, noise, loss), measured_(measured) {
    check_measurement(*this, measured, "value");
  }

  const Vector& measured() const { return measured_; }
  std::string name() const override { return "prior"; }

  Vector evaluate(const Vector& x, Eigen::Matrix<double, N, N>* J) const override {
    if (J != nullptr) J->setIdentity();
    return x - measured_;
  }

 private:
  Vector measured_;
};

}  // namespace hybrid
