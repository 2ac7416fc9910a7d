// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, the hybrid mapping authors
#pragma once

#include <Eigen/Core>
#include <Eigen/Geometry>

#include "libhybrid/geometry/so3.h"

namespace HYBRID_API hybrid {

/// Rigid motion in space. Tangent: (translation [m], rotation vector [rad]), in the local (right)
/// frame.
class SE3 {
 public:
  static constexpr int kDim = 6;   ///< size of the tangent
  static constexpr int kSize = 7;  ///< doubles in storage: x, y, z, qx, qy, qz, qw
  using Point = Eigen::Vector3d;
  using Tangent = Eigen::Matrix<double, 6, 1>;
  using Jacobian = Eigen::Matrix<double, 6, 6>;

  SE3() = default;
  SE3(const Eigen::Vector3d& translation, const SO3& rotation)
      : translation_(translation), rotation_(rotation) {}
  SE3(const Eigen::Vector3d& translation, const Eigen::Quaterniond& q)
      : translation_(translation), rotation_(q) {}

  const Eigen::Vector3d& translation() const { return translation_; }
  const SO3& rotation() const { return rotation_; }
  /// Homogeneous 4 x 4 matrix.
  Eigen::Matrix4d matrix() const;

  SE3 inverse() const {
    const SO3 r = rotation_.inverse();
    return {-(r * translation_), r};
  }
  friend SE3 operator*(const SE3& a, const SE3& b) {
    return {a.translation_ + a.rotation_ * b.translation_, a.rotation_ * b.rotation_};
  }
  /// inverse() * b, in fewer operations.
  SE3 between(const SE3& b) const {
    const SO3 r = rotation_.inverse();
    return {r * (b.translation_ - translation_), r * b.rotation_};
  }
  Eigen::Vector3d operator*(const Eigen::Vector3d& p) const { return translation_ + rotation_ * p; }

  static SE3 exp(const Tangent& v);
  /// The rotation part has norm at most pi. `inverse`, if not null, receives right_jacobian_inverse
  /// of the result, cheaper than by a call of its own.
  Tangent log(Jacobian* inverse = nullptr) const;
  /// T Exp(v) = Exp(adjoint() v) T.
  Jacobian adjoint() const;
  /// J inverse().adjoint(), for J a Jacobian or adjoint of the group, that is [A B; 0 A].
  Jacobian times_inverse_adjoint(const Jacobian& J) const;
  /// Exp(v + d) = Exp(v) Exp(Jr(v) d) to first order in d.
  static Jacobian right_jacobian(const Tangent& v);
  static Jacobian right_jacobian_inverse(const Tangent& v);

  static SE3 load(const double* x) { return {{x[0], x[1], x[2]}, SO3::load(x + 3)}; }
  void store(double* x) const {
    Eigen::Map<Eigen::Vector3d>{x} = translation_;
    rotation_.store(x + 3);
  }
  bool is_unit() const { return rotation_.is_unit(); }
  void normalize() { rotation_.normalize(); }

 private:
  Eigen::Vector3d translation_ = Eigen::Vector3d::Zero();
  SO3 rotation_;
};

}  // namespace hybrid
