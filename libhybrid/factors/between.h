// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, the hybrid mapping authors
#pragma once

#include <optional>
#include <string>
#include <type_traits>

#include "libhybrid/factors/factor_of.h"
#include "libhybrid/factors/relative_pose.h"
#include "libhybrid/geometry/se2.h"
#include "libhybrid/geometry/se3.h"

namespace hybrid {

/// A measured relative motion z of b seen from a: residual log(z^-1 a^-1 b), eq. 15.
template <class Group>
class Between : public FactorOf<Group::kDim, Group, Group> {
 public:
  using Base = FactorOf<Group::kDim, Group, Group>;
  using Matrix = typename Group::Jacobian;

  /// Throws Error for a motion that is not finite.
  Between(Key a, Key b, const Group& measured, const Noise& noise, Loss loss = {})
      : Base({a, b}, noise, loss), measured_(measured) {
    check_measurement(*this, measured, "motion");
  }

  const Group& measured() const { return measured_; }
  std::string name() const override { return "between"; }
  std::optional<RelativePose<SE2>> relative_pose_2d() const override {
    if constexpr (std::is_same_v<Group, SE2>) {
      return relative_pose_of(measured_, this->sqrt_information());
    }
    return std::nullopt;
  }
  std::optional<RelativePose<SE3>> relative_pose_3d() const override {
    if constexpr (std::is_same_v<Group, SE3>) {
      return relative_pose_of(measured_, this->sqrt_information());
    }
    return std::nullopt;
  }

  typename Base::Residual evaluate(const Group& a, const Group& b, Matrix* Ja,
                                   Matrix* Jb) const override {
    const Group h = a.between(b);
    const auto e = measured_.between(h).log(Jb);
    if (Ja != nullptr) *Ja = -h.times_inverse_adjoint(*Jb);
    return e;
  }

 private:
  Group measured_;
};

/// A measured difference of two vectors: residual b - a - z.
template <int N>
class Between<Eigen::Matrix<double, N, 1>>
    : public FactorOf<N, Eigen::Matrix<double, N, 1>, Eigen::Matrix<double, N, 1>> {
 public:
  using Vector = Eigen::Matrix<double, N, 1>;
  using Matrix = Eigen::Matrix<double, N, N>;

  /// Throws Error for a difference that is not finite.
  Between(Key a, Key b, const Vector& measured, const Noise& noise, Loss loss = {})
      : FactorOf<N, Vector, Vector>({a, b}, noise, loss), measured_(measured) {
    check_measurement(*this, measured, "difference");
  }

  const Vector& measured() const { return measured_; }
  std::string name() const override { return "between"; }

  Vector evaluate(const Vector& a, const Vector& b, Matrix* Ja, Matrix* Jb) const override {
    if (Ja != nullptr) *Ja = -Matrix::Identity();
    if (Jb != nullptr) Jb->setIdentity();
    return b - a - measured_;
  }

 private:
  Vector measured_;
};

/// A measured planar motion with the residual of translation in the measured frame and plain angle
/// difference, (R_z' (t_ab - t_z), wrap(angle_ab - angle_z)). It converges from far worse starts
/// than the group logarithm, whose translation part mixes with large angle errors; hence the
/// default of readers.
class BetweenSE2 : public FactorOf<3, SE2, SE2> {
 public:
  /// Throws Error for a motion that is not finite.
  BetweenSE2(Key a, Key b, const SE2& measured, const Noise& noise, Loss loss = {})
      : FactorOf({a, b}, noise, loss), measured_(measured) {
    check_measurement(*this, measured, "motion");
  }

  const SE2& measured() const { return measured_; }
  std::string name() const override { return "between"; }
  std::optional<RelativePose<SE2>> relative_pose_2d() const override {
    return relative_pose_of(measured_, sqrt_information());
  }

  Residual evaluate(const SE2& a, const SE2& b, Jacobian<SE2>* Ja,
                    Jacobian<SE2>* Jb) const override;

 private:
  SE2 measured_;
};

}  // namespace hybrid
