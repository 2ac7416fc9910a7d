// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, the hybrid mapping authors
#include "libhybrid/factors/calibrated_motion.h"

#include "libhybrid/factors/sensor_view.h"

namespace hybrid {

SE2 calibrated(const SE2& measured, const OdometryCalibration2& c, Eigen::Matrix3d* J) {
  const double driven = measured.translation().norm();
  const double angle = measured.angle();
  const SE2 z(c[0] * measured.translation(), SO2(c[1] * angle + c[2] * driven));
  if (J != nullptr) {
    J->setZero();
    J->col(0).head<2>() = z.rotation().inverse() * measured.translation();
    (*J)(2, 1) = angle;
    (*J)(2, 2) = driven;
  }
  return z;
}

SE3 calibrated(const SE3& measured, const OdometryCalibration3& c, Eigen::Matrix<double, 6, 5>* J) {
  const double driven = measured.translation().norm();
  const Eigen::Vector3d turned = measured.rotation().log();
  const Eigen::Vector3d rotation = c[1] * turned + driven * c.tail<3>();
  const SE3 z(c[0] * measured.translation(), SO3::exp(rotation));
  if (J != nullptr) {
    const Eigen::Matrix3d Jr = SO3::right_jacobian(rotation);
    J->setZero();
    J->col(0).head<3>() = z.rotation().inverse() * measured.translation();
    J->col(1).tail<3>() = Jr * turned;
    J->bottomRightCorner<3, 3>() = driven * Jr;
  }
  return z;
}

CalibratedMotion2::Residual CalibratedMotion2::evaluate(const SE2& a, const SE2& b,
                                                        const OdometryCalibration2& c,
                                                        Jacobian<SE2>* Ja, Jacobian<SE2>* Jb,
                                                        Jacobian<OdometryCalibration2>* Jc) const {
  Eigen::Matrix3d by_calibration;
  const SE2 z = calibrated(measured_, c, Jc != nullptr ? &by_calibration : nullptr);
  const SE2 h = a.between(b);
  const SE2 d = z.between(h);
  if (Ja != nullptr) {
    const Eigen::Matrix2d R = d.rotation().matrix();
    const Eigen::Matrix2d to_measured = z.rotation().matrix().transpose();
    Jb->setIdentity();
    Jb->topLeftCorner<2, 2>() = R;
    Ja->setIdentity();
    *Ja *= -1.0;
    Ja->topLeftCorner<2, 2>() = -to_measured;
    Ja->topRightCorner<2, 1>() = to_measured * rotation_derivative(h.translation());
    Eigen::Matrix3d by_z = -Eigen::Matrix3d::Identity();
    by_z.topRightCorner<2, 1>() = rotation_derivative(d.translation());
    Jc->noalias() = by_z * by_calibration;
  }
  return {d.x(), d.y(), d.angle()};
}

CalibratedMotion3::Residual CalibratedMotion3::evaluate(const SE3& a, const SE3& b,
                                                        const OdometryCalibration3& c,
                                                        Jacobian<SE3>* Ja, Jacobian<SE3>* Jb,
                                                        Jacobian<OdometryCalibration3>* Jc) const {
  Eigen::Matrix<double, 6, 5> by_calibration;
  const SE3 z = calibrated(measured_, c, Jc != nullptr ? &by_calibration : nullptr);
  const SE3 h = a.between(b);
  const SE3 d = z.between(h);
  const Residual e = d.log(Jb);
  if (Ja != nullptr) {
    *Ja = -h.times_inverse_adjoint(*Jb);
    Jc->noalias() = -d.times_inverse_adjoint(*Jb) * by_calibration;
  }
  return e;
}

}  // namespace hybrid
