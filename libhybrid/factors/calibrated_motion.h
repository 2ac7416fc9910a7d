// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, the hybrid mapping authors
#pragma once

#include <Eigen/Core>
#include <string>

#include "libhybrid/factors/factor_of.h"
#include "libhybrid/geometry/se2.h"
#include "libhybrid/geometry/se3.h"

namespace HYBRID_API hybrid {

/// The systematic errors of odometry, a variable that all motions share: (scale of translation,
/// scale of rotation, drift of the rotation [rad per metre driven]). The drift is a number in the
/// plane and a rotation vector in space. Without error it is (1, 1, 0).
using OdometryCalibration2 = Eigen::Vector3d;
using OdometryCalibration3 = Eigen::Matrix<double, 5, 1>;

/// The motion that odometry should have measured: translation c_0 t and rotation c_1 r + |t| drift,
/// where (t, r) was measured. `by_calibration`, if not null, receives its derivative in the tangent
/// of the result.
SE2 calibrated(const SE2& measured, const OdometryCalibration2& c,
               Eigen::Matrix3d* by_calibration = nullptr);
SE3 calibrated(const SE3& measured, const OdometryCalibration3& c,
               Eigen::Matrix<double, 6, 5>* by_calibration = nullptr);

/// BetweenSE2 with the odometry's calibration as a third variable: residual (R_z' (t_ab - t_z),
/// wrap(angle_ab - angle_z)) for z the calibrated motion.
class CalibratedMotion2 : public FactorOf<3, SE2, SE2, OdometryCalibration2> {
 public:
  CalibratedMotion2(Key a, Key b, Key calibration, const SE2& measured, const Noise& noise,
                    Loss loss = {})
      : FactorOf({a, b, calibration}, noise, loss), measured_(measured) {
    check_measurement(*this, measured, "motion");
  }

  const SE2& measured() const { return measured_; }
  /// The motion as the calibration among `values` has it.
  SE2 motion(const Values& values) const {
    return calibrated(measured_, values.at<OdometryCalibration2>(keys()[2]));
  }
  std::string name() const override { return "calibrated motion"; }

  Residual evaluate(const SE2& a, const SE2& b, const OdometryCalibration2& c, Jacobian<SE2>* Ja,
                    Jacobian<SE2>* Jb, Jacobian<OdometryCalibration2>* Jc) const override;

 private:
  SE2 measured_;
};

/// Between<SE3> with the odometry's calibration as a third variable: residual log(z^-1 a^-1 b) for
/// z the calibrated motion.
class CalibratedMotion3 : public FactorOf<6, SE3, SE3, OdometryCalibration3> {
 public:
  CalibratedMotion3(Key a, Key b, Key calibration, const SE3& measured, const Noise& noise,
                    Loss loss = {})
      : FactorOf({a, b, calibration}, noise, loss), measured_(measured) {
    check_measurement(*this, measured, "motion");
  }

  const SE3& measured() const { return measured_; }
  /// The motion as the calibration among `values` has it.
  SE3 motion(const Values& values) const {
    return calibrated(measured_, values.at<OdometryCalibration3>(keys()[2]));
  }
  std::string name() const override { return "calibrated motion"; }

  Residual evaluate(const SE3& a, const SE3& b, const OdometryCalibration3& c, Jacobian<SE3>* Ja,
                    Jacobian<SE3>* Jb, Jacobian<OdometryCalibration3>* Jc) const override;

 private:
  SE3 measured_;
};

}  // namespace hybrid
