// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, the hybrid mapping authors
#pragma once

#include <string>

#include "libhybrid/factors/carried_point.h"
#include "libhybrid/factors/factor_of.h"
#include "libhybrid/factors/sensor_view.h"

namespace HYBRID_API hybrid {

/// A measured distance [m] between two things that have a position, each a pose or a point:
/// Range<SE2, Eigen::Vector2d>, Range<SE3, SE3>, Range<Eigen::Vector3d, Eigen::Vector3d>. The
/// offsets are the positions of the antennas in the frames of a and b. Residual: distance - z. At
/// distance zero, where it has no derivative, the derivative along the first axis of `a` is used
/// (any direction is a subgradient), so that a solver can leave it.
template <class A, class B>
class Range : public FactorOf<1, A, B> {
 public:
  using Base = FactorOf<1, A, B>;
  using Point = typename PositionOf<A>::type;
  static constexpr int kPointDim = Point::RowsAtCompileTime;

  /// Throws Error for a range that is negative or not finite.
  Range(Key a, Key b, double measured, const Noise& noise, const Point& offset_a = Point::Zero(),
        const Point& offset_b = Point::Zero(), Loss loss = {})
      : Base({a, b}, noise, loss), measured_(measured), offset_a_(offset_a), offset_b_(offset_b) {
    check_range(*this, measured);
  }

  double measured() const { return measured_; }
  const Point& offset_a() const { return offset_a_; }
  const Point& offset_b() const { return offset_b_; }
  std::string name() const override { return "range"; }

  typename Base::Residual evaluate(const A& a, const B& b, typename Base::template Jacobian<A>* Ja,
                                   typename Base::template Jacobian<B>* Jb) const override {
    Eigen::Matrix<double, kPointDim, Variable<A>::kDim> Da;
    Eigen::Matrix<double, kPointDim, Variable<B>::kDim> Db;
    const bool derive = Ja != nullptr;
    const Point d = carried_point(b, offset_b_, derive ? &Db : nullptr) -
                    carried_point(a, offset_a_, derive ? &Da : nullptr);
    const double range = d.norm();
    if (derive) {
      const Point u = range > 0.0 ? Point(d / range) : Point(Da.col(0));
      Ja->noalias() = -u.transpose() * Da;
      Jb->noalias() = u.transpose() * Db;
    }
    return typename Base::Residual(range - measured_);
  }

 private:
  double measured_;
  Point offset_a_;
  Point offset_b_;
};

}  // namespace hybrid
