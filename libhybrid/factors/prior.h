// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, the hybrid mapping authors
#pragma once

#include <string>

#include "libhybrid/factors/factor_of.h"

namespace HYBRID_API hybrid {

/// A direct measurement z of a variable of any type: residual x boxminus z; for vectors and numbers
/// x - z.
template <class T>
class Prior : public FactorOf<Variable<T>::kDim, T> {
 public:
  using Base = FactorOf<Variable<T>::kDim, T>;

  /// Throws Error for a value that is not finite.
  Prior(Key key, const T& measured, const Noise& noise, Loss loss = {})
      : Base({key}, noise, loss), measured_(measured) {
    check_measurement(*this, measured, "value");
  }

  const T& measured() const { return measured_; }
  std::string name() const override { return "prior"; }

  typename Base::Residual evaluate(const T& x,
                                   typename Base::template Jacobian<T>* J) const override {
    if constexpr (is_group<T>) {
      return measured_.between(x).log(J);
    } else if constexpr (is_vector<T>) {
      if (J != nullptr) J->setIdentity();
      return typename Base::Residual(x - measured_);
    } else {
      double z[Variable<T>::kSize], y[Variable<T>::kSize];
      Variable<T>::store(measured_, z);
      Variable<T>::store(x, y);
      if (J != nullptr) *J = local_jacobian(Variable<T>::type(), z, y);
      return Variable<T>::local(measured_, x);
    }
  }

 private:
  T measured_;
};

}  // namespace hybrid
