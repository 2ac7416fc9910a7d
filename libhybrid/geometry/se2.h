// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, the hybrid mapping authors
#pragma once

#include <Eigen/Core>

#include "libhybrid/geometry/so2.h"

namespace HYBRID_API hybrid {

/// Rigid motion in the plane. Tangent: (x, y [m], angle [rad]), in the local (right) frame.
class SE2 {
 public:
  static constexpr int kDim = 3;   ///< size of the tangent
  static constexpr int kSize = 4;  ///< doubles in storage: x, y, cos, sin
  using Point = Eigen::Vector2d;
  using Tangent = Eigen::Vector3d;
  using Jacobian = Eigen::Matrix3d;

  SE2() = default;
  SE2(double x, double y, double angle) : translation_(x, y), rotation_(angle) {}
  SE2(const Eigen::Vector2d& translation, const SO2& rotation)
      : translation_(translation), rotation_(rotation) {}

  const Eigen::Vector2d& translation() const { return translation_; }
  const SO2& rotation() const { return rotation_; }
  double x() const { return translation_.x(); }
  double y() const { return translation_.y(); }
  /// In (-pi, pi].
  double angle() const { return rotation_.angle(); }
  /// Homogeneous 3 x 3 matrix.
  Eigen::Matrix3d matrix() const;

  SE2 inverse() const {
    const SO2 r = rotation_.inverse();
    return {-(r * translation_), r};
  }
  friend SE2 operator*(const SE2& a, const SE2& b) {
    return {a.translation_ + a.rotation_ * b.translation_, a.rotation_ * b.rotation_};
  }
  /// inverse() * b, in fewer operations.
  SE2 between(const SE2& b) const {
    const SO2 r = rotation_.inverse();
    return {r * (b.translation_ - translation_), r * b.rotation_};
  }
  Eigen::Vector2d operator*(const Eigen::Vector2d& p) const { return translation_ + rotation_ * p; }

  static SE2 exp(const Tangent& v);
  /// `inverse`, if not null, receives right_jacobian_inverse of the result, cheaper than by a call
  /// of its own.
  Tangent log(Jacobian* inverse = nullptr) const;
  /// T Exp(v) = Exp(adjoint() v) T.
  Jacobian adjoint() const;
  /// J inverse().adjoint(), for J a Jacobian or adjoint of the group.
  Jacobian times_inverse_adjoint(const Jacobian& J) const { return J * inverse().adjoint(); }
  /// Exp(v + d) = Exp(v) Exp(Jr(v) d) to first order in d.
  static Jacobian right_jacobian(const Tangent& v);
  static Jacobian right_jacobian_inverse(const Tangent& v);

  static SE2 load(const double* x) { return {{x[0], x[1]}, SO2::load(x + 2)}; }
  void store(double* x) const {
    x[0] = translation_.x();
    x[1] = translation_.y();
    rotation_.store(x + 2);
  }
  bool is_unit() const { return rotation_.is_unit(); }
  void normalize() { rotation_.normalize(); }

 private:
  Eigen::Vector2d translation_ = Eigen::Vector2d::Zero();
  SO2 rotation_;
};

}  // namespace hybrid
