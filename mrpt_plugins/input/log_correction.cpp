// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, the hybrid mapping authors

#include "mrpt_plugins/input/log_correction.h"

#include <algorithm>
#include <cmath>
#include <utility>

#include "libhybrid/geometry/isometry.h"

namespace hybrid {
namespace {

/// The variance by a model, where there is one.
void set_variance(const std::optional<NoiseModel>& model, double by, double& variance) {
  if (!model) return;
  if (model->is_scaled) {
    variance *= model->factor * model->factor;
  } else {
    variance = std::pow(model->constant, 2) + std::pow(model->by_range * by, 2);
  }
}

}  // namespace

void LogCorrection::correct(double time, DetectionFrame& frame) const {
  const auto found = sensors.find(frame.sensor_label);
  if (found == sensors.end()) return;
  const SensorCorrection& sensor = found->second;
  if (sensor.yaw != 0) {
    frame.T_robot_sensor = compose(
        frame.T_robot_sensor,
        to_isometry(SE3(Eigen::Vector3d::Zero(), SO3::exp(Eigen::Vector3d(0, 0, sensor.yaw)))));
  }
  if (sensor.delay != 0 && path && !path->empty()) {
    const SE3 now = pose_at(*path, time);
    frame.T_robot_sensor = compose(to_isometry(now.between(pose_at(*path, time - sensor.delay))),
                                   frame.T_robot_sensor);
  }
  for (Detection& d : frame.detections) {
    if (sensor.mirrored) {
      d.yaw = -d.yaw;
      d.covariance.row(1) = -d.covariance.row(1).eval();
      d.covariance.col(1) = -d.covariance.col(1).eval();
    }
    if (!frame.has_range) continue;
    d.range *= sensor.length;
    const Eigen::Vector3d before = d.covariance.diagonal();
    set_variance(sensor.range, d.range, d.covariance(0, 0));
    set_variance(sensor.angle, 1 / std::max(1e-3, d.range), d.covariance(1, 1));
    if (frame.is_3d) {
      set_variance(sensor.angle, 1 / std::max(1e-3, d.range), d.covariance(2, 2));
    }
    // Correlations stay as they were.
    for (int i = 0; i < 3; ++i) {
      for (int j = 0; j < 3; ++j) {
        const double scale = before[i] * before[j];
        if (i == j || !(scale > 0)) continue;
        d.covariance(i, j) *= std::sqrt(d.covariance(i, i) * d.covariance(j, j) / scale);
      }
    }
  }
}

void LogCorrection::correct(OdometryIncrement& odometry) const {
  if (translation == 1 && rotation == 1) return;
  Eigen::Matrix<double, 6, 1> scale;
  scale << Eigen::Vector3d::Constant(translation), Eigen::Vector3d::Constant(rotation);
  odometry.covariance = scale.asDiagonal() * odometry.covariance * scale.asDiagonal();
}

void LogCorrection::correct(const std::string& label, LaserScan& scan) const {
  const auto found = lasers.find(label);
  if (found != lasers.end()) scan = corrected(std::move(scan), found->second);
}

void LogCorrection::correct(Fix& fix) const {
  const auto found = receivers.find(fix.sensor);
  if (found == receivers.end()) return;
  fix.sigma *= found->second.sigma_factor;
  fix.delay = found->second.delay;
  fix.receiver = found->second.model;
}

bool LogCorrection::is_none() const {
  return receivers.empty() && translation == 1 && rotation == 1 && !hides_ids &&
         std::all_of(lasers.begin(), lasers.end(),
                     [](const auto& laser) { return laser.second.is_as_stated(); }) &&
         std::all_of(sensors.begin(), sensors.end(),
                     [](const auto& sensor) { return sensor.second.is_none(); });
}

}  // namespace hybrid
