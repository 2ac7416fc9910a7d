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

/// `covariance_of(J)` is the covariance of J x, with x the tangent of the pose and the landmarks,
/// in that order.
template <class Pose, class CovarianceOfJ>
PredictedSightings predict_sightings_by(const Pose& T_map_robot, const Pose& T_robot_sensor,
                                        const std::vector<typename Pose::Point>& landmarks,
                                        const CovarianceOfJ& covariance_of) {
  constexpr int kDim = Pose::Point::RowsAtCompileTime;
  using View = SensorView<Pose>;
  const View view(T_robot_sensor);
  const int n = static_cast<int>(landmarks.size());
  PredictedSightings out;
  out.dim = kDim;
  out.mean.resize(kDim, n);
  Eigen::MatrixXd J = Eigen::MatrixXd::Zero(kDim * n, Pose::kDim + kDim * n);
  for (int j = 0; j < n; ++j) {
    typename View::PoseMatrix by_pose;
    typename View::Matrix by_point;
    out.mean.col(j) = view.polar(T_map_robot, landmarks[j], &by_pose, &by_point);
    J.template block<kDim, Pose::kDim>(kDim * j, 0) = by_pose;
    J.template block<kDim, kDim>(kDim * j, Pose::kDim + kDim * j) = by_point;
  }
  out.covariance = covariance_of(J);
  return out;
}

/// The same with `joint`, the covariance of x.
template <class Pose>
PredictedSightings predict_sightings(const Pose& T_map_robot, const Pose& T_robot_sensor,
                                     const std::vector<typename Pose::Point>& landmarks,
                                     const Eigen::MatrixXd& joint) {
  return predict_sightings_by(
      T_map_robot, T_robot_sensor, landmarks,
      [&](const Eigen::MatrixXd& J) -> Eigen::MatrixXd { return J * joint * J.transpose(); });
}

}  // namespace hybrid
