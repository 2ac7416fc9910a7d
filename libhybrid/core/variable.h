// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, the hybrid mapping authors
#pragma once

#include <Eigen/Core>
#include <string>
#include <type_traits>

#include "libhybrid/geometry/se2.h"
#include "libhybrid/geometry/se3.h"
#include "libhybrid/geometry/so2.h"
#include "libhybrid/geometry/so3.h"

namespace HYBRID_API hybrid {

/// Vectors (points, biases, calibrations), the groups of this library, and manifolds of users.
enum class VariableKind : unsigned char { kVector, kSO2, kSE2, kSO3, kSE3, kManifold };

/// The operations of a user's manifold on flat storage; made by manifold_type().
struct Manifold {
  const char* name;
  void (*retract)(const double* x, const double* delta, double* out);
  void (*local)(const double* x, const double* y, double* delta);
  void (*normalize)(double* x);
};

/// The type of a variable at run time: its kind, and the sizes of its tangent and storage (in
/// doubles).
struct VariableType {
  VariableKind kind = VariableKind::kVector;
  int dim = 0;
  int size = 0;
  const Manifold* manifold = nullptr;  ///< null unless the kind is kManifold

  friend bool operator==(VariableType a, VariableType b) {
    return a.kind == b.kind && a.dim == b.dim &&
           (a.manifold == b.manifold || same_manifold(*a.manifold, *b.manifold));
  }
  friend bool operator!=(VariableType a, VariableType b) { return !(a == b); }

 private:
  /// Compares names, since two shared libraries may each have a copy of a manifold.
  static bool same_manifold(const Manifold& a, const Manifold& b);
};

/// Whether a variable is a pose, SE2 or SE3.
inline bool is_pose(VariableType type) {
  return type.kind == VariableKind::kSE2 || type.kind == VariableKind::kSE3;
}

/// The type of vectors whose length is known at run time only.
inline VariableType vector_type(int dim) {
  return {VariableKind::kVector, dim, dim};
}

/// "SE2", "SE3", "vector of 2", ... for messages.
std::string to_string(VariableType type);

/// out = x boxplus delta: x Exp(delta) for groups, x + delta for vectors. `out` may be `x`.
void retract(VariableType type, const double* x, const double* delta, double* out);

/// Scales a rotation to unit norm unless it has it already; not a number if it is zero. The value
/// of a user's manifold is loaded and stored again.
void normalize(VariableType type, double* x);

/// delta = y boxminus x, so that retract(x, delta) gives y.
void local(VariableType type, const double* x, const double* y, double* delta);

/// Derivative of y boxminus x with respect to the tangent at y (dim x dim); of manifolds of users
/// by central differences.
Eigen::MatrixXd local_jacobian(VariableType type, const double* x, const double* y);

/// Derivative of the storage of x boxplus delta with respect to delta at zero (size x dim,
/// column-major); of manifolds of users by central differences.
void retract_jacobian(VariableType type, const double* x, double* jacobian);

/// The type of a manifold with these traits: kName, kDim, kSize, load, store, retract(value,
/// tangent) and local(value, other). `load` inverts `store`, and projects numbers that are slightly
/// off the manifold onto it.
template <class Traits>
VariableType manifold_type();

/// A C++ type as a variable: its flat storage, its retraction and its local coordinates.
///
/// A class of your own becomes a variable everywhere (values, factors, marginals, windows) if it
/// has kName, kDim, kSize, `static T load(const double*)`, `void store(double*) const`,
/// `T retract(const Tangent&) const` and `Tangent local(const T&) const`, where Tangent is
/// Eigen::Matrix<double, kDim, 1> and x.retract(x.local(y)) is y. For a class that you cannot
/// change, specialise this struct with the same names.
template <class T>
struct Variable {
  static constexpr const char* kName = T::kName;
  static constexpr int kDim = T::kDim;
  static constexpr int kSize = T::kSize;
  using Tangent = Eigen::Matrix<double, kDim, 1>;
  static T load(const double* x) { return T::load(x); }
  static void store(const T& value, double* x) { value.store(x); }
  static T retract(const T& x, const Tangent& delta) { return x.retract(delta); }
  static Tangent local(const T& x, const T& y) { return x.local(y); }
  static VariableType type() { return manifold_type<Variable<T>>(); }
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

/// Whether T is a group of this library, with between() and log().
template <class T>
inline constexpr bool is_group = std::is_same_v<T, SO2> || std::is_same_v<T, SE2> ||
                                 std::is_same_v<T, SO3> || std::is_same_v<T, SE3>;

/// Whether T is a vector of fixed length, or a number.
template <class T>
inline constexpr bool is_vector = std::is_same_v<T, double>;
template <int N>
inline constexpr bool is_vector<Eigen::Matrix<double, N, 1>> = true;

/// A number: a vector of length 1.
template <>
struct Variable<double> {
  static constexpr int kDim = 1;
  static constexpr int kSize = 1;
  static double load(const double* x) { return *x; }
  static void store(double value, double* x) { *x = value; }
  static VariableType type() { return vector_type(1); }
};

template <class Traits>
VariableType manifold_type() {
  using Tangent = Eigen::Map<const Eigen::Matrix<double, Traits::kDim, 1>>;
  static constexpr Manifold kManifold{Traits::kName,
                                      [](const double* x, const double* delta, double* out) {
                                        Traits::store(
                                            Traits::retract(Traits::load(x), Tangent(delta)), out);
                                      },
                                      [](const double* x, const double* y, double* delta) {
                                        Eigen::Map<Eigen::Matrix<double, Traits::kDim, 1>>{delta} =
                                            Traits::local(Traits::load(x), Traits::load(y));
                                      },
                                      [](double* x) { Traits::store(Traits::load(x), x); }};
  return {VariableKind::kManifold, Traits::kDim, Traits::kSize, &kManifold};
}

}  // namespace hybrid
