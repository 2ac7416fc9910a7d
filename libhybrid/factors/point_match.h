// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, the hybrid mapping authors
#pragma once

#include <string>

#include "libhybrid/factors/factor_of.h"
#include "libhybrid/factors/sensor_view.h"

namespace HYBRID_API hybrid {

/// A match of the points `p` of a source cloud and `q` of a target cloud: residual T_target_source
/// p - q in the axes and unit of the target. With isotropic noise it is a point-to-point distance,
/// with noise that is small along the normal at `q` a point-to-plane distance.
class PointMatch : public FactorOf<3, SE3> {
 public:
  /// Throws Error for a coordinate that is not finite.
  PointMatch(Key T_target_source, const Eigen::Vector3d& p, const Eigen::Vector3d& q,
             const Noise& noise, Loss loss = {})
      : FactorOf({T_target_source}, noise, loss), p_(p), q_(q) {
    check_measurement(*this, p, "point");
    check_measurement(*this, q, "point");
  }

  std::string name() const override { return "point match"; }

  Eigen::Vector3d evaluate(const SE3& T, Jacobian<SE3>* J) const override {
    if (J != nullptr) {
      const Eigen::Matrix3d R = T.rotation().matrix();
      *J << R, -R * hat(p_);
    }
    return T * p_ - q_;
  }

 private:
  Eigen::Vector3d p_, q_;
};

}  // namespace hybrid
