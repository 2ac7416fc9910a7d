// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, the hybrid mapping authors
#pragma once

#include <string>

#include "libhybrid/factors/factor_of.h"
#include "libhybrid/factors/sensor_view.h"

namespace HYBRID_API hybrid {

/// Three poses in a row, equally far apart in time, of a robot whose speed changes little: residual
/// R_b' (t_c - t_b) - R_a' (t_b - t_a), the change of its step in its own axes [m].
template <class Pose>
class SteadyMotion : public FactorOf<Pose::Point::RowsAtCompileTime, Pose, Pose, Pose> {
 public:
  using Point = typename Pose::Point;
  static constexpr int kPointDim = Point::RowsAtCompileTime;
  using Base = FactorOf<kPointDim, Pose, Pose, Pose>;
  using Matrix = Eigen::Matrix<double, kPointDim, Pose::kDim>;

  SteadyMotion(Key a, Key b, Key c, const Noise& noise, Loss loss = {})
      : Base({a, b, c}, noise, loss) {}

  std::string name() const override { return "steady motion"; }

  Point evaluate(const Pose& a, const Pose& b, const Pose& c, Matrix* Ja, Matrix* Jb,
                 Matrix* Jc) const override {
    Matrix by_a, by_b, by_next;
    const bool derive = Ja != nullptr;
    const Point u = step(a, b, derive ? &by_a : nullptr, derive ? &by_b : nullptr);
    const Point v = step(b, c, derive ? &by_next : nullptr, Jc);
    if (derive) {
      *Ja = -by_a;
      *Jb = by_next - by_b;
    }
    return v - u;
  }

 private:
  /// The position of `to` in the frame of `from`.
  static Point step(const Pose& from, const Pose& to, Matrix* by_from, Matrix* by_to) {
    const auto R = from.rotation().matrix();
    const Point p = R.transpose() * (to.translation() - from.translation());
    if (by_from != nullptr) {
      by_from->template leftCols<kPointDim>().setIdentity();
      by_from->template leftCols<kPointDim>() *= -1.0;
      by_from->template rightCols<Pose::kDim - kPointDim>() = rotation_derivative(p);
    }
    if (by_to != nullptr) {
      by_to->setZero();
      by_to->template leftCols<kPointDim>() = R.transpose() * to.rotation().matrix();
    }
    return p;
  }
};

}  // namespace hybrid
