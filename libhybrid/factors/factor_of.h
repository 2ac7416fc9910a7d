// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, the hybrid mapping authors
#pragma once

#include <Eigen/Core>
#include <array>
#include <cmath>
#include <string>
#include <tuple>
#include <utility>

#include "libhybrid/core/loss.h"
#include "libhybrid/core/noise.h"
#include "libhybrid/factors/factor.h"

namespace HYBRID_API hybrid {

/// Throws Error, which names the factor, unless all numbers of a measured vector or group element
/// are finite.
template <class T>
void check_measurement(const ContinuousFactor& factor, const T& z, const char* what) {
  double x[Variable<T>::kSize];
  Variable<T>::store(z, x);
  for (double entry : x) {
    if (std::isfinite(entry)) continue;
    throw Error(describe(factor.name(), factor.keys()) + ": the measured " + what +
                " is not finite");
  }
}

/// Throws Error, which names the factor, unless a measured range is finite and not negative.
inline void check_range(const ContinuousFactor& factor, double range) {
  if (range >= 0.0 && std::isfinite(range)) return;
  throw Error(describe(factor.name(), factor.keys()) +
              ": the measured range must be finite and not negative, got " + std::to_string(range));
}

/// Base of continuous factors whose residual size and variable types are known at compile time. A
/// derived class defines `evaluate`: the residual and, if the pointers are not null, its Jacobian
/// with respect to the tangent of each variable. Whitening, robust loss and storage are done here.
template <int kRows, class... Variables>
class FactorOf : public ContinuousFactor {
 public:
  static constexpr int kCols = (Variable<Variables>::kDim + ...);
  using Residual = Eigen::Matrix<double, kRows, 1>;
  template <class V>
  using Jacobian = Eigen::Matrix<double, kRows, Variable<V>::kDim>;

  /// Residual at the given variables, not whitened, in the units of the measurement.
  virtual Residual evaluate(const Variables&... x, Jacobian<Variables>*... jacobians) const = 0;

  double cost(const double* const* x) const final {
    return cost_at(x, std::index_sequence_for<Variables...>{});
  }
  double linearize(const double* const* x, double* r, double* J) const final {
    return linearize_at(x, r, J, std::index_sequence_for<Variables...>{});
  }
  double log_normalizer() const final { return log_normalizer_; }

  const Loss& loss() const { return loss_; }
  const Eigen::Matrix<double, kRows, kRows>& sqrt_information() const { return sqrt_information_; }

  using ContinuousFactor::cost;

 protected:
  FactorOf(const std::array<Key, sizeof...(Variables)>& keys, const Noise& noise, Loss loss = {})
      : ContinuousFactor({keys.begin(), keys.end()}, {Variable<Variables>::type()...}, kRows),
        loss_(loss),
        log_normalizer_(noise.log_normalizer()) {
    if (noise.dim() != kRows) {
      throw Error(describe("a", this->keys()) + ": noise of dimension " +
                  std::to_string(noise.dim()) + " for a residual of " + std::to_string(kRows));
    }
    if (!(loss.parameter > 0.0)) {
      throw Error("the parameter of a robust loss must be positive, got " +
                  std::to_string(loss.parameter));
    }
    sqrt_information_ = noise.sqrt_information();
    diagonal_ = sqrt_information_.isDiagonal(0.0);
  }

 private:
  template <std::size_t... I>
  double cost_at(const double* const* x, std::index_sequence<I...>) const {
    const Residual e =
        evaluate(Variable<Variables>::load(x[I])..., static_cast<Jacobian<Variables>*>(nullptr)...);
    Residual whitened;
    whiten(e, whitened);
    return 0.5 * loss_.value(whitened.squaredNorm());
  }

  template <std::size_t... I>
  double linearize_at(const double* const* x, double* r, double* J,
                      std::index_sequence<I...>) const {
    std::tuple<Jacobian<Variables>...> jacobians;
    const Residual e = evaluate(Variable<Variables>::load(x[I])..., &std::get<I>(jacobians)...);
    Residual whitened;  // local, so that the compiler keeps it in registers
    whiten(e, whitened);
    (append(std::get<I>(jacobians), J), ...);
    const double s = whitened.squaredNorm();
    if (loss_.kind == Loss::Kind::kNone) {
      Eigen::Map<Residual>{r} = whitened;
      return 0.5 * s;
    }
    const double root = std::sqrt(loss_.weight(s));
    Eigen::Map<Residual>{r} = root * whitened;
    Eigen::Map<Eigen::Matrix<double, kRows, kCols>>(J - kRows * kCols) *= root;
    return 0.5 * loss_.value(s);
  }

  template <class Block, class Out>
  void whiten(const Block& block, Out&& out) const {
    if (diagonal_) {
      out.noalias() = sqrt_information_.diagonal().asDiagonal() * block;
    } else {
      out.noalias() = sqrt_information_ * block;
    }
  }

  /// Writes the whitened Jacobian of one variable at `J` and advances `J` to the next.
  template <class Block>
  void append(const Block& jacobian, double*& J) const {
    whiten(jacobian, Eigen::Map<Block>{J});
    J += kRows * Block::ColsAtCompileTime;
  }

  Eigen::Matrix<double, kRows, kRows> sqrt_information_;
  Loss loss_;
  double log_normalizer_;
  bool diagonal_;
};

/// The noise of a factor.
template <int kRows, class... Variables>
Noise noise_of(const FactorOf<kRows, Variables...>& factor) {
  const auto& R = factor.sqrt_information();
  return Noise::information(R.transpose() * R);
}

}  // namespace hybrid
