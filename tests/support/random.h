// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, the hybrid mapping authors
#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <random>

#include "libhybrid/core/noise.h"
#include "libhybrid/core/variable.h"

namespace hybrid::testing {

/// Random values for tests, the same on every machine for the same seed.
class Random {
 public:
  explicit Random(std::uint64_t seed = 1) : engine_(seed) {}

  /// Uniform in [low, high). The standard defines the engine, but its distributions differ between
  /// libraries.
  double uniform(double low = 0.0, double high = 1.0) {
    return low + (high - low) * static_cast<double>(engine_() >> 11) * 0x1.0p-53;
  }
  /// Normal with mean zero.
  double normal(double sigma = 1.0) {
    const double radius = std::sqrt(-2.0 * std::log(1.0 - uniform()));
    return sigma * radius * std::cos(2.0 * M_PI * uniform());
  }
  /// Uniform in 0 .. bound - 1.
  int below(int bound) { return static_cast<int>(uniform(0.0, bound)); }

  /// Entries normal with the given standard deviation.
  template <int N>
  Eigen::Matrix<double, N, 1> vector(double sigma = 1.0) {
    Eigen::Matrix<double, N, 1> v;
    for (double& entry : v) entry = normal(sigma);
    return v;
  }

  /// A group element whose tangent is normal, or a vector of normal entries.
  template <class T>
  T value(double sigma = 1.0) {
    const auto v = vector<Variable<T>::kDim>(sigma);
    if constexpr (std::is_convertible_v<decltype(v), T>) {
      return v;
    } else {
      return T::exp(v);
    }
  }

  /// A full covariance with standard deviations of about `sigma`.
  Noise noise(int dim, double sigma = 1.0) {
    Eigen::MatrixXd a(dim, dim);
    for (int i = 0; i < dim * dim; ++i) a.data()[i] = normal(0.3 * sigma);
    return Noise::covariance(a * a.transpose() +
                             sigma * sigma * 0.5 * Eigen::MatrixXd::Identity(dim, dim));
  }

 private:
  std::mt19937_64 engine_;
};

}  // namespace hybrid::testing
