// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, the hybrid mapping authors
#pragma once

#include <Eigen/Core>
#include <vector>

#include "libhybrid/association/gate.h"
#include "libhybrid/association/matching.h"
#include "libhybrid/core/noise.h"
#include "libhybrid/factors/sensor_view.h"

namespace HYBRID_API hybrid {

/// A measured range and direction and its noise: (range, bearing) or (range, yaw, pitch).
struct MeasuredPoint {
  Eigen::VectorXd z;
  Eigen::MatrixXd covariance;
};

/// The sightings to expect of some landmarks, one Gaussian over all of them: what the joint
/// covariance of the pose and the landmarks (eq. 11b) says, without the noise of the sensor.
struct PredictedSightings {
  int dim = 0;                 ///< of one sighting, 2 or 3
  Eigen::MatrixXd mean;        ///< dim x landmarks
  Eigen::MatrixXd covariance;  ///< (dim landmarks) x (dim landmarks)

  /// z less what is expected of landmark j, angles wrapped to [-pi, pi].
  Eigen::VectorXd innovation(const Eigen::VectorXd& z, int j) const;
  /// Score of detection `measured` as a sighting of landmark j.
  GaussianScore score(const MeasuredPoint& measured, int j) const;
  /// Score of all the matched detections together, correlations included (joint compatibility).
  GaussianScore score(const std::vector<MeasuredPoint>& measured, const Matching& matching) const;
};

/// `joint` is the covariance of the tangent of the pose and the landmarks, in that order.
template <class Pose>
PredictedSightings predict_sightings(const Pose& T_map_robot, const Pose& T_robot_sensor,
                                     const std::vector<typename Pose::Point>& landmarks,
                                     const Eigen::MatrixXd& joint) {
  constexpr int kDim = Pose::Point::RowsAtCompileTime;
  using View = SensorView<Pose>;
  const View view(T_robot_sensor);
  const int n = static_cast<int>(landmarks.size());
  PredictedSightings out;
  out.dim = kDim;
  out.mean.resize(kDim, n);
  out.covariance.resize(kDim * n, kDim * n);
  std::vector<typename View::PoseMatrix> by_pose(n);
  std::vector<typename View::Matrix> by_point(n);
  for (int j = 0; j < n; ++j) {
    out.mean.col(j) = view.polar(T_map_robot, landmarks[j], &by_pose[j], &by_point[j]);
  }
  const typename Pose::Jacobian P = joint.template topLeftCorner<Pose::kDim, Pose::kDim>();
  for (int i = 0; i < n; ++i) {
    // Of what sighting i depends on, with the pose and with landmark j.
    const Eigen::Matrix<double, kDim, Pose::kDim> with_pose =
        by_pose[i] * P +
        by_point[i] * joint.template block<kDim, Pose::kDim>(Pose::kDim + kDim * i, 0);
    for (int j = i; j < n; ++j) {
      const int row = Pose::kDim + kDim * i, col = Pose::kDim + kDim * j;
      const typename View::Matrix with_point =
          by_pose[i] * joint.template block<Pose::kDim, kDim>(0, col) +
          by_point[i] * joint.template block<kDim, kDim>(row, col);
      const typename View::Matrix block =
          with_pose * by_pose[j].transpose() + with_point * by_point[j].transpose();
      out.covariance.template block<kDim, kDim>(kDim * i, kDim * j) = block;
      out.covariance.template block<kDim, kDim>(kDim * j, kDim * i) = block.transpose();
    }
  }
  return out;
}

}  // namespace hybrid
