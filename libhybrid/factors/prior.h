// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, the hybrid mapping authors
#pragma once

#include <string>

#include "libhybrid/factors/factor_of.h"

namespace hybrid {

/// A direct measurement z of a variable, of a group or of a manifold of a user: residual
/// x boxminus z.
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
    if constexpr (is_group<Group>) {
      return measured_.between(x).log(J);
    } else {
      double z[Variable<Group>::kSize], y[Variable<Group>::kSize];
      Variable<Group>::store(measured_, z);
      Variable<Group>::store(x, y);
      if (J != nullptr) *J = local_jacobian(Variable<Group>::type(), z, y);
      return Variable<Group>::local(measured_, x);
    }
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

/// The same for numbers.
template <>
class Prior<double> : public FactorOf<1, double> {
 public:
  /// Throws Error for a value that is not finite.
  Prior(Key key, double measured, const Noise& noise, Loss loss = {})
      : FactorOf({key}, noise, loss), measured_(measured) {
    check_measurement(*this, measured, "value");
  }

  double measured() const { return measured_; }
  std::string name() const override { return "prior"; }

  Residual evaluate(const double& x, Jacobian<double>* J) const override {
    if (J != nullptr) J->setOnes();
    return Residual(x - measured_);
  }

 private:
  double measured_;
};

}  // namespace hybrid
