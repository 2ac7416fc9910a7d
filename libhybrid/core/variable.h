// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, the hybrid mapping authors
#pragma once

#include <Eigen/Core>
#include <string>

#include "libhybrid/geometry/se2.h"
#include "libhybrid/geometry/se3.h"
#include "libhybrid/geometry/so2.h"
#include "libhybrid/geometry/so3.h"

namespace hybrid {

/// The closed set of continuous variables: vectors (points, biases, calibrations) and the groups.
enum class VariableKind : unsigned char { kVector, kSO2, kSE2, kSO3, kSE3 };

/// What a variable is at run time: its kind, the size of its tangent and of its storage (in
/// doubles).
struct VariableType {
  VariableKind kind = VariableKind::kVector;
  int dim = 0;
  int size = 0;

  friend bool operator==(VariableType a, VariableType b) {
    return a.kind == b.kind && a.dim == b.dim;
  }
  friend bool operator!=(VariableType a, VariableType b) { return !(a == b); }
};

/// "SE2", "SE3", "vector of 2", ... for messages.
std::string to_string(VariableType type);

/// out = x boxplus delta: x Exp(delta) for groups, x + delta for vectors. `out` may be `x`.
void retract(VariableType type, const double* x, const double* delta, double* out);

/// Scales the rotation of a group to unit norm where it is not of it; not a number where it is
/// zero.
void normalize(VariableType type, double* x);

/// delta = y boxminus x, so that retract(x, delta) gives y.
void local(VariableType type, const double* x, const double* y, double* delta);

/// Compile-time view of a variable: how a C++ type sits in flat storage.
template <class T>
struct Variable {
  static constexpr int kDim = T::kDim;
  static constexpr int kSize = T::kSize;
  static T load(const double* x) { return T::load(x); }
  static void store(const T& value, double* x) { value.store(x); }
  static VariableType type();
};

template <>
inline VariableType Variable<SO2>::type() {
  return {VariableKind::kSO2, kDim, kSize};
}
template <>
inline VariableType Variable<SE2>::type() {
  return {VariableKind::kSE2, kDim, kSize};
}
template <>
inline VariableType Variable<SO3>::type() {
  return {VariableKind::kSO3, kDim, kSize};
}
template <>
inline VariableType Variable<SE3>::type() {
  return {VariableKind::kSE3, kDim, kSize};
}

template <int N>
struct Variable<Eigen::Matrix<double, N, 1>> {
  static_assert(N > 0, "vectors have a fixed size");
  static constexpr int kDim = N;
  static constexpr int kSize = N;
  using T = Eigen::Matrix<double, N, 1>;
  static T load(const double* x) { return Eigen::Map<const T>(x); }
  static void store(const T& value, double* x) { Eigen::Map<T>{x} = value; }
  static VariableType type() { return {VariableKind::kVector, N, N}; }
};

}  // namespace hybrid
