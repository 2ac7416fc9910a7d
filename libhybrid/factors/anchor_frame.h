// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, the hybrid mapping authors
#pragma once

#include <Eigen/Core>
#include <algorithm>
#include <limits>

#include "libhybrid/core/variable.h"
#include "libhybrid/factors/sensor_view.h"

namespace HYBRID_API hybrid {

/// Coordinates of a point at q0 + d in which a rotation about the origin is linear in its angle to
/// second order: d + (|d|^2 q0 - (q0'd) d) / (2 (|q0|^2 + |d|^2)). Positions of a point seen from a
/// pose of uncertain heading form an arc; the displacement d alone would replace the arc by its
/// tangent, where the point is too far away by half the squared angle. `by_d`, if not null,
/// receives the derivative with respect to d.
template <class Point, class Matrix>
Point straighten(const Point& q0, const Point& d, Matrix* by_d) {
  const double dd = d.squaredNorm();
  const double qd = q0.dot(d);
  // At q0 = d = 0 both parts of the bend vanish.
  const double k = 1.0 / std::max(q0.squaredNorm() + dd, std::numeric_limits<double>::min());
  const Point bend = 0.5 * k * (dd * q0 - qd * d);
  if (by_d != nullptr) {
    *by_d = k * ((q0 - 2.0 * bend) * d.transpose() - 0.5 * d * q0.transpose());
    by_d->diagonal().array() += 1.0 - 0.5 * k * qd;
  }
  return d + bend;
}

/// The frame of a pose (SE2 or SE3), in which other poses and points are expressed.
template <class Pose>
class AnchorFrame {
 public:
  using Point = typename Pose::Point;
  static constexpr int kPointDim = Point::RowsAtCompileTime;

  /// Coordinates of a variable, and their derivatives with respect to its tangent and that of the
  /// anchor.
  template <class T>
  struct Coordinates {
    static constexpr int kDim = Variable<T>::kDim;
    Eigen::Matrix<double, kDim, 1> e;
    Eigen::Matrix<double, kDim, kDim> by_variable;
    Eigen::Matrix<double, kDim, Pose::kDim> by_anchor;
  };

  explicit AnchorFrame(const Pose& anchor) : anchor_(anchor) {}

  /// Calls visit(variable) with the pose or point stored at x; no other type is allowed.
  template <class Visit>
  static void load(VariableType type, const double* x, const Visit& visit) {
    type == Variable<Pose>::type() ? visit(Pose::load(x)) : visit(Variable<Point>::load(x));
  }
  static bool takes(VariableType type) {
    return type == Variable<Pose>::type() || type == Variable<Point>::type();
  }

  /// A pose or point in the frame of the anchor.
  Pose express(const Pose& x) const { return anchor_.between(x); }
  Point express(const Point& x) const { return anchor_.inverse() * x; }

  /// Coordinates of a pose: the tangent from `expressed`, its value in the frame of the anchor at
  /// x0, to its present one.
  Coordinates<Pose> coordinates(const Pose& expressed, const Pose& x) const {
    Coordinates<Pose> out;
    const Pose h = express(x);
    out.e = expressed.between(h).log(&out.by_variable);
    out.by_anchor = -h.times_inverse_adjoint(out.by_variable);
    return out;
  }
  /// Coordinates of a point: its displacement from `expressed`, straightened.
  Coordinates<Point> coordinates(const Point& expressed, const Point& x) const {
    Coordinates<Point> out;
    const Point q = express(x);
    Eigen::Matrix<double, kPointDim, kPointDim> D;
    out.e = straighten(expressed, Point(q - expressed), &D);
    out.by_variable = D * anchor_.rotation().matrix().transpose();
    out.by_anchor << -D, D * rotation_derivative(q);
    return out;
  }

 private:
  Pose anchor_;
};

}  // namespace hybrid
