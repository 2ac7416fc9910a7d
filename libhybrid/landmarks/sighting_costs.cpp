// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, the hybrid mapping authors

#include "libhybrid/landmarks/sighting_costs.h"

#include "libhybrid/core/spatial_values.h"
#include "libhybrid/detections/sighting.h"
#include "libhybrid/geometry/polar.h"
#include "libhybrid/geometry/so2.h"
#include "libhybrid/landmarks/sensor_place.h"

namespace hybrid {

GaussianScore SightingCosts::place(int s, int t) const {
  const Sighting& sighting = landmarks_.sighting(s);
  const Eigen::Isometry3d T_map_sensor = sensor_pose(isometry_at(map_.values, sighting.pose),
                                                     *sighting.sensor, map_.values, map_.is_3d);
  const Eigen::Vector3d point = point_at(map_.values, landmarks_.track(t).position);
  const Eigen::Vector3d expected = to_polar(
      Eigen::Vector3d(T_map_sensor.linear().transpose() * (point - T_map_sensor.translation())));
  const MeasuredPoint measured = measured_point(landmarks_.detection_of(s, t), map_.is_3d);
  Eigen::VectorXd innovation = measured.z - expected.head(measured.z.size());
  innovation[1] = wrap_angle(innovation[1]);
  return gaussian_score(innovation, measured.covariance);
}

double SightingCosts::classes(int s, int t) const {
  const Track& track = landmarks_.track(t);
  if (!track.class_key) return 0;
  return class_cost(landmarks_.sighting(s).phi, landmarks_.class_belief(track, classes_));
}

double SightingCosts::unknown_classes(int s) const {
  if (classes_.names().empty()) return 0;
  return class_cost(landmarks_.sighting(s).phi, classes_.prior());
}

}  // namespace hybrid
