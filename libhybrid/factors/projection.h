// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, the hybrid mapping authors
#pragma once

#include <string>

#include "libhybrid/factors/factor_of.h"
#include "libhybrid/factors/sensor_view.h"

namespace HYBRID_API hybrid {

/// A pinhole camera with square pixels and radial distortion, as a variable: focal length and
/// principal point [pixels], and the coefficients k1, k2 of radius^2 and radius^4.
using Intrinsics = Eigen::Matrix<double, 5, 1>;  // f, cx, cy, k1, k2

/// The pixel at which a camera sees a point: for (x, y, z) in the camera frame (z ahead, x right, y
/// down) with u = (x, y) / z and s = 1 + k1 |u|^2 + k2 |u|^4, the pixel f s u + (cx, cy). A depth z
/// below kNearest [unit of length], also a negative one, is replaced by it, which makes the
/// residual huge and the Jacobian finite.
struct PinholeView {
  static constexpr double kNearest = 1e-6;

  Eigen::Vector2d pixel;
  Eigen::Matrix<double, 2, 3> by_point;  ///< in the camera frame
  Eigen::Matrix<double, 2, 5> by_intrinsics;

  PinholeView(const Eigen::Vector3d& p, const Intrinsics& camera, bool jacobians);
};

/// The pixel at which a camera at T_map_camera saw a point of the map, with pose, point and
/// intrinsics all unknown: residual in pixels. Projections with the same intrinsics variable are of
/// the same camera.
class Projection : public FactorOf<2, SE3, Eigen::Vector3d, Intrinsics> {
 public:
  /// Throws Error for a pixel that is not finite.
  Projection(Key pose, Key point, Key intrinsics, const Eigen::Vector2d& pixel, const Noise& noise,
             Loss loss = {})
      : FactorOf({pose, point, intrinsics}, noise, loss), pixel_(pixel) {
    check_measurement(*this, pixel, "pixel");
  }

  const Eigen::Vector2d& pixel() const { return pixel_; }
  std::string name() const override { return "projection"; }

  Eigen::Vector2d evaluate(const SE3& T_map_camera, const Eigen::Vector3d& p_map,
                           const Intrinsics& camera, Jacobian<SE3>* by_pose,
                           Jacobian<Eigen::Vector3d>* by_point,
                           Jacobian<Intrinsics>* by_intrinsics) const override {
    const Eigen::Matrix3d R_camera_map = T_map_camera.rotation().matrix().transpose();
    const Eigen::Vector3d p = R_camera_map * (p_map - T_map_camera.translation());
    const PinholeView view(p, camera, by_pose != nullptr);
    if (by_pose != nullptr) {
      *by_pose << -view.by_point, view.by_point * hat(p);
      *by_point = view.by_point * R_camera_map;
      *by_intrinsics = view.by_intrinsics;
    }
    return view.pixel - pixel_;
  }

 private:
  Eigen::Vector2d pixel_;
};

inline PinholeView::PinholeView(const Eigen::Vector3d& p, const Intrinsics& camera,
                                bool jacobians) {
  const bool near = p.z() < kNearest;
  const double inverse = 1.0 / (near ? kNearest : p.z());
  const Eigen::Vector2d u = p.head<2>() * inverse;
  const double f = camera[0], k1 = camera[3], k2 = camera[4];
  const double q = u.squaredNorm();
  const double s = 1.0 + q * (k1 + q * k2);
  pixel = f * s * u + camera.segment<2>(1);
  if (!jacobians) return;
  // d(s u)/du = s I + u (ds/dq) 2 u'.
  const Eigen::Matrix2d by_u =
      f * (s * Eigen::Matrix2d::Identity() + 2.0 * (k1 + 2.0 * q * k2) * u * u.transpose());
  by_point.leftCols<2>() = by_u * inverse;
  by_point.col(2) = near ? Eigen::Vector2d::Zero().eval() : (-by_u * u * inverse).eval();
  by_intrinsics << s * u, Eigen::Matrix2d::Identity(), f * q * u, f * q * q * u;
}

}  // namespace hybrid
