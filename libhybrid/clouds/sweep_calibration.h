// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, the hybrid mapping authors

#pragma once

#include <vector>

#include "libhybrid/clouds/cloud_alignment.h"

namespace HYBRID_API hybrid {

/// How long a lidar takes to turn around once, where its points have no times: a share of the time
/// from cloud to cloud, positive where it turns to the left. It looks ahead at the stamp. Measured
/// from how clouds fit each other while the sensor moves: poses and surfaces are functions of the
/// share. Their shifts are, first, the derivatives by it, and, second, by how much the shares that
/// were taken out so far have moved them.
class SweepCalibration {
 public:
  using PoseShifts = Eigen::Matrix<double, 6, 2>;  ///< in the tangent of the pose

  /// The most likely share, and its standard deviation.
  double share() const { return share_; }
  double sigma() const { return sigma_; }

  /// The next cloud as it would have been seen at once, in the frame of the robot. `motion` is that
  /// since the cloud before. A cloud that `is_at_once`, and one of a sensor that does not see on
  /// all sides, is left as it is.
  std::vector<Eigen::Vector3f> deskewed(std::vector<Eigen::Vector3f> points,
                                        const Eigen::Vector3f& sensor, const SE3& motion,
                                        bool is_at_once);
  /// Shifts of points of that cloud along their normals, wherever it is.
  std::vector<SurfaceShifts> shifts_of(const std::vector<CloudPoint>& points) const;

  /// Where that cloud should be in a map, and the shifts of this.
  struct Prediction {
    SE3 pose;
    Matrix6 information;
    PoseShifts shifts;
  };
  /// Learns from that cloud, which was found to be at `found`. Returns the shifts of this pose.
  PoseShifts learn(const std::vector<CloudPoint>& points, const CloudSurfaces& map,
                   const CloudAlignment& found, const Prediction& predicted);

 private:
  SurfaceShifts own_shifts(const CloudPoint& point, const Eigen::Vector3d& normal) const;
  Eigen::Vector3d derivative_at(const Eigen::Vector3d& point) const;

  double share_ = 0, sigma_ = 0.5;  // at first no lidar is known, which turns in most of the time
  // Of the newest cloud:
  bool applies_ = false;
  Eigen::Vector3d sensor_ = Eigen::Vector3d::Zero();
  SE3::Tangent motion_ = SE3::Tangent::Zero();
};

/// Shifts of points of a cloud along their normals, at a pose that shifts, too.
std::vector<SurfaceShifts> shifts_at(const SweepCalibration::PoseShifts& pose,
                                     const std::vector<CloudPoint>& points,
                                     std::vector<SurfaceShifts> shifts);

}  // namespace hybrid
