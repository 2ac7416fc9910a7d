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

namespace HYBRID_API hybrid {

/// A measured relative motion z of b seen from a: residual log(z^-1 a^-1 b), eq. 15; for vectors
/// and numbers b - a - z.
template <class T>
class Between : public FactorOf<Variable<T>::kDim, T, T> {
 public:
  using Base = FactorOf<Variable<T>::kDim, T, T>;
  using Matrix = typename Base::template Jacobian<T>;

  /// Throws Error for a motion that is not finite.
  Between(Key a, Key b, const T& measured, const Noise& noise, Loss loss = {})
      : Base({a, b}, noise, loss), measured_(measured) {
    check_measurement(*this, measured, is_vector<T> ? "difference" : "motion");
  }

  const T& measured() const { return measured_; }
  std::string name() const override { return "between"; }
  std::optional<RelativePose<SE2>> relative_pose_2d() const override { return motion<SE2>(); }
  std::optional<RelativePose<SE3>> relative_pose_3d() const override { return motion<SE3>(); }

  typename Base::Residual evaluate(const T& a, const T& b, Matrix* Ja, Matrix* Jb) const override {
    if constexpr (is_vector<T>) {
      if (Ja != nullptr) *Ja = -Matrix::Identity();
      if (Jb != nullptr) Jb->setIdentity();
      return typename Base::Residual(b - a - measured_);
    } else {
      const T h = a.between(b);
      const auto e = measured_.between(h).log(Jb);
      if (Ja != nullptr) *Ja = -h.times_inverse_adjoint(*Jb);
      return e;
    }
  }

 private:
  template <class Pose>
  std::optional<RelativePose<Pose>> motion() const {
    if constexpr (std::is_same_v<T, Pose>) {
      return relative_pose_of(measured_, this->sqrt_information());
    } else {
      return std::nullopt;
    }
  }

  T measured_;
};

/// A measured planar motion whose residual is the translation error in the measured frame and the
/// angle difference, (R_z' (t_ab - t_z), wrap(angle_ab - angle_z)). Readers of graphs use it, since
/// it converges from far worse initial values than the group logarithm, whose translation part
/// depends on large angle errors.
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
