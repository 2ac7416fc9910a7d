// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, the hybrid mapping authors
#pragma once

#include <Eigen/Core>
#include <Eigen/Geometry>
#include <cmath>

#include "libhybrid/core/variable.h"
#include "libhybrid/geometry/se3.h"

namespace hybrid::testing {

/// A similarity p -> s R p + t as a user-defined variable. Steps move the rigid part as in SE3, and
/// the scale s by exp.
struct Sim3 {
  static constexpr const char* kName = "Sim3";
  static constexpr int kDim = 7;
  static constexpr int kSize = 8;
  using Tangent = Eigen::Matrix<double, kDim, 1>;

  SE3 rigid;
  double scale = 1;

  static Sim3 load(const double* x) {
    SE3 rigid = SE3::load(x);
    rigid.normalize();
    return {rigid, x[7]};
  }
  void store(double* x) const {
    rigid.store(x);
    x[7] = scale;
  }
  Sim3 retract(const Tangent& delta) const {
    return {rigid * SE3::exp(delta.head<6>()), scale * std::exp(delta[6])};
  }
  Tangent local(const Sim3& other) const {
    Tangent delta;
    delta << (rigid.inverse() * other.rigid).log(), std::log(other.scale / scale);
    return delta;
  }
};

/// A direction: a unit vector in 3-D. Steps follow great circles.
struct S2 {
  static constexpr const char* kName = "S2";
  static constexpr int kDim = 2;
  static constexpr int kSize = 3;
  using Tangent = Eigen::Vector2d;

  Eigen::Vector3d v = Eigen::Vector3d::UnitX();

  static S2 load(const double* x) { return {Eigen::Vector3d(x[0], x[1], x[2]).normalized()}; }
  void store(double* x) const { Eigen::Map<Eigen::Vector3d>{x} = v; }
  /// Two unit vectors orthogonal to v and to each other, a smooth function of v almost everywhere.
  Eigen::Matrix<double, 3, 2> basis() const {
    const Eigen::Matrix3d R =
        Eigen::Quaterniond::FromTwoVectors(Eigen::Vector3d::UnitX(), v).toRotationMatrix();
    return R.rightCols<2>();
  }
  S2 retract(const Tangent& delta) const {
    const double angle = delta.norm();
    const double share = angle < 1e-9 ? 1 - angle * angle / 6 : std::sin(angle) / angle;
    return {(std::cos(angle) * v + basis() * (share * delta)).normalized()};
  }
  Tangent local(const S2& other) const {
    const Tangent across = basis().transpose() * other.v;
    const double sine = across.norm(), angle = std::atan2(sine, v.dot(other.v));
    return sine < 1e-12 ? across : Tangent(angle / sine * across);
  }
};

}  // namespace hybrid::testing
