// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, the hybrid mapping authors
#pragma once

#include <ceres/jet.h>

#include <array>
#include <string>
#include <tuple>
#include <utility>

#include "libhybrid/factors/factor_of.h"

namespace HYBRID_API hybrid {

/// A factor given by its residual alone: dual numbers (ceres::Jet, header only; Debian:
/// libceres-dev) compute the Jacobian, at several times the cost of an analytic one (see
/// bench-factors).
///
/// `Residual` is a function object with
///
///     template <class S>
///     Eigen::Matrix<S, kRows, 1> operator()(const Eigen::Matrix<S, kSize, 1>&... x) const;
///
/// whose arguments are the variables as they are stored: vectors and numbers as they are, SO2 as
/// cos, sin; SE2 as x, y, cos, sin; SO3 as the quaternion x, y, z, w; SE3 as x, y, z and the
/// quaternion. The residual is not whitened, in the units of the measurement.
template <int kRows, class Residual, class... Variables>
class AutoDiffFactor : public FactorOf<kRows, Variables...> {
 public:
  using Base = FactorOf<kRows, Variables...>;

  /// `name` is for messages.
  AutoDiffFactor(const std::array<Key, sizeof...(Variables)>& keys, Residual residual,
                 const Noise& noise, Loss loss = {}, std::string name = "user's")
      : Base(keys, noise, loss), residual_(std::move(residual)), name_(std::move(name)) {}

  std::string name() const override { return name_; }

  typename Base::Residual evaluate(
      const Variables&... x, typename Base::template Jacobian<Variables>*... J) const override {
    const bool wants = ((J != nullptr) || ...);
    if (!wants) return residual_(storage<Variables>(x)...);
    int first = 0;
    // Elements of a braced list are evaluated from left to right.
    const std::tuple<Inputs<Variables>...> inputs{jets<Variables>(x, first)...};
    const auto out = std::apply(residual_, inputs);
    first = 0;
    (chain<Variables>(x, out, first, J), ...);
    typename Base::Residual e;
    for (int i = 0; i < kRows; ++i) e[i] = out[i].a;
    return e;
  }

 private:
  static constexpr int kInputs = (Variable<Variables>::kSize + ...);
  using Jet = ceres::Jet<double, kInputs>;
  template <class V>
  using Inputs = Eigen::Matrix<Jet, Variable<V>::kSize, 1>;

  template <class V>
  static auto storage(const V& x) {
    Eigen::Matrix<double, Variable<V>::kSize, 1> out;
    Variable<V>::store(x, out.data());
    return out;
  }

  /// The storage of a variable as dual numbers, whose derivatives start at input `first`; advances
  /// `first`.
  template <class V>
  static Inputs<V> jets(const V& x, int& first) {
    const auto values = storage(x);
    Inputs<V> out;
    for (int i = 0; i < Variable<V>::kSize; ++i) out[i] = Jet(values[i], first + i);
    first += Variable<V>::kSize;
    return out;
  }

  /// The Jacobian with respect to the tangent, from the derivatives with respect to the storage.
  template <class V, class Out>
  static void chain(const V& x, const Out& out, int& first,
                    typename Base::template Jacobian<V>* J) {
    constexpr int kSize = Variable<V>::kSize;
    if (J != nullptr) {
      Eigen::Matrix<double, kRows, kSize> by_storage;
      for (int i = 0; i < kRows; ++i) {
        by_storage.row(i) = out[i].v.template segment<kSize>(first).transpose();
      }
      Eigen::Matrix<double, kSize, Variable<V>::kDim> by_tangent;
      retract_jacobian(Variable<V>::type(), storage(x).data(), by_tangent.data());
      J->noalias() = by_storage * by_tangent;
    }
    first += kSize;
  }

  Residual residual_;
  std::string name_;
};

}  // namespace hybrid
