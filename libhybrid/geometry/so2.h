// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, the hybrid mapping authors
#pragma once

#include <cmath>

#include "libhybrid/geometry/arc.h"
#include "libhybrid/geometry/eigen.h"
#include "libhybrid/geometry/normalize.h"

namespace HYBRID_API hybrid {

/// The angle in [-pi, pi] that equals `angle` modulo 2 pi.
inline double wrap_angle(double angle) {
  return std::abs(angle) <= M_PI ? angle : std::remainder(angle, 2.0 * M_PI);
}

/// Rotation in the plane, held as cosine and sine. Tangent: the angle [rad].
class SO2 {
 public:
  static constexpr int kDim = 1;   ///< size of the tangent
  static constexpr int kSize = 2;  ///< doubles in storage: cos, sin
  using Tangent = Eigen::Matrix<double, 1, 1>;
  using Jacobian = Eigen::Matrix<double, 1, 1>;

  SO2() : SO2(1.0, 0.0) {}
  explicit SO2(double angle) : c_(std::cos(angle)), s_(std::sin(angle)) {}
  /// The rotation by the angle of (c, s); not a number if (c, s) is zero or not finite, which
  /// Values and factors refuse.
  static SO2 from_cos_sin(double c, double s) {
    SO2 r(c, s);
    if (!r.is_unit()) r.normalize();
    return r;
  }

  double cos() const { return c_; }
  double sin() const { return s_; }
  /// In (-pi, pi].
  double angle() const {
    if (c_ > 0.0 && s_ * s_ < detail::kSmallTangent * c_ * c_) {
      const double tangent = s_ / c_;
      return tangent * detail::arc_series(tangent * tangent);
    }
    return std::atan2(s_, c_);
  }
  Eigen::Matrix2d matrix() const { return (Eigen::Matrix2d() << c_, -s_, s_, c_).finished(); }

  SO2 inverse() const { return {c_, -s_}; }
  friend SO2 operator*(const SO2& a, const SO2& b) {
    return {a.c_ * b.c_ - a.s_ * b.s_, a.s_ * b.c_ + a.c_ * b.s_};
  }
  /// inverse() * b.
  SO2 between(const SO2& b) const { return inverse() * b; }
  Eigen::Vector2d operator*(const Eigen::Vector2d& p) const {
    return {c_ * p.x() - s_ * p.y(), s_ * p.x() + c_ * p.y()};
  }

  static SO2 exp(const Tangent& v) { return SO2(v[0]); }
  /// `inverse`, if not null, receives right_jacobian_inverse of the result.
  Tangent log(Jacobian* inverse = nullptr) const {
    if (inverse != nullptr) inverse->setIdentity();
    return Tangent(angle());
  }
  Jacobian adjoint() const { return Jacobian::Identity(); }
  /// J inverse().adjoint(), for J a Jacobian or adjoint of the group.
  Jacobian times_inverse_adjoint(const Jacobian& J) const { return J; }
  static Jacobian right_jacobian(const Tangent&) { return Jacobian::Identity(); }
  static Jacobian right_jacobian_inverse(const Tangent&) { return Jacobian::Identity(); }

  /// Reads storage without normalisation.
  static SO2 load(const double* x) { return {x[0], x[1]}; }
  void store(double* x) const {
    x[0] = c_;
    x[1] = s_;
  }
  /// Whether (cos, sin) is of unit norm, but for the rounding of some thousand compositions.
  bool is_unit() const { return detail::is_unit(c_ * c_ + s_ * s_); }
  /// Scales (cos, sin) to unit norm; not a number if it is zero.
  void normalize() {
    Eigen::Vector2d v(c_, s_);
    detail::normalize(v);
    c_ = v.x();
    s_ = v.y();
  }

 private:
  SO2(double c, double s) : c_(c), s_(s) {}

  double c_;
  double s_;
};

}  // namespace hybrid
