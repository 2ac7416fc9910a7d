// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, the hybrid mapping authors
#pragma once

#include <Eigen/Geometry>
#include <cmath>

#include "libhybrid/geometry/eigen.h"
#include "libhybrid/geometry/normalize.h"

namespace HYBRID_API hybrid {

/// The 3 x 3 matrix with hat(a) b = a x b.
inline Eigen::Matrix3d hat(const Eigen::Vector3d& v) {
  Eigen::Matrix3d m;
  m << 0.0, -v.z(), v.y(),  //
      v.z(), 0.0, -v.x(),   //
      -v.y(), v.x(), 0.0;
  return m;
}

/// Rotation in space, held as a unit quaternion. Tangent: rotation vector [rad], in the local
/// (right) frame.
class SO3 {
 public:
  static constexpr int kDim = 3;   ///< size of the tangent
  static constexpr int kSize = 4;  ///< doubles in storage: qx, qy, qz, qw
  using Tangent = Eigen::Vector3d;
  using Jacobian = Eigen::Matrix3d;

  SO3() : q_(Eigen::Quaterniond::Identity()) {}
  /// The rotation of q / |q|; not a number if q is zero or not finite, which Values and factors
  /// refuse.
  explicit SO3(const Eigen::Quaterniond& q) : q_(q) {
    if (!is_unit()) normalize();
  }

  const Eigen::Quaterniond& quaternion() const { return q_; }
  Eigen::Matrix3d matrix() const { return q_.toRotationMatrix(); }

  SO3 inverse() const { return {q_.conjugate(), Unit()}; }
  friend SO3 operator*(const SO3& a, const SO3& b) { return {a.q_ * b.q_, Unit()}; }
  /// inverse() * b.
  SO3 between(const SO3& b) const { return inverse() * b; }
  Eigen::Vector3d operator*(const Eigen::Vector3d& p) const {
    const Eigen::Vector3d v = q_.vec();
    const Eigen::Vector3d u = 2.0 * v.cross(p);
    return p + q_.w() * u + v.cross(u);
  }

  static SO3 exp(const Tangent& v);
  /// The norm is at most pi. `inverse`, if not null, receives right_jacobian_inverse of the result,
  /// cheaper than by a call of its own.
  Tangent log(Jacobian* inverse = nullptr) const;
  Jacobian adjoint() const { return matrix(); }
  /// J inverse().adjoint(), for J a Jacobian or adjoint of the group.
  Jacobian times_inverse_adjoint(const Jacobian& J) const { return J * matrix().transpose(); }
  /// Exp(v + d) = Exp(v) Exp(Jr(v) d) to first order in d.
  static Jacobian right_jacobian(const Tangent& v);
  static Jacobian right_jacobian_inverse(const Tangent& v);

  /// cot(t / 2) for t the norm of log(), infinite at the identity.
  double half_cot() const { return std::abs(q_.w()) / q_.vec().norm(); }

  /// Reads storage without normalisation.
  static SO3 load(const double* x) { return {Eigen::Quaterniond(x[3], x[0], x[1], x[2]), Unit()}; }
  void store(double* x) const { Eigen::Map<Eigen::Vector4d>{x} = q_.coeffs(); }
  /// Whether the quaternion is of unit norm, but for the rounding of some thousand compositions.
  bool is_unit() const { return detail::is_unit(q_.squaredNorm()); }
  /// Scales the quaternion to unit norm; not a number if it is zero.
  void normalize() { detail::normalize(q_.coeffs()); }

 private:
  struct Unit {};
  SO3(const Eigen::Quaterniond& q, Unit) : q_(q) {}

  Eigen::Quaterniond q_;
};

}  // namespace hybrid
