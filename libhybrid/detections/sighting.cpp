// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, the hybrid mapping authors

#include "libhybrid/detections/sighting.h"

#include <algorithm>
#include <cmath>
#include <memory>

#include "libhybrid/core/key_letters.h"
#include "libhybrid/core/spatial_values.h"
#include "libhybrid/factors/bearing.h"
#include "libhybrid/factors/bearing_range.h"
#include "libhybrid/factors/calibrated_bearing_range.h"
#include "libhybrid/geometry/polar.h"
#include "libhybrid/geometry/so2.h"

namespace hybrid {
namespace {

constexpr std::size_t kMostAlike = 10;  // detections, a budget
/// Of the noise of a range: nearer than this its sensor may be on either side of what it measures.
constexpr double kNearSigmas = 3.0;

/// Variances of yaw and pitch of what is off across its direction by this variance [m^2].
Eigen::Vector2d across(double range, double pitch, double variance, bool is_3d) {
  const double square = std::max(range * range, variance);  // nearer, all directions are alike
  return {variance / (square * std::pow(std::cos(pitch), 2)), is_3d ? variance / square : 0};
}

}  // namespace

bool is_wanted(const std::string& sensor, const std::vector<std::string>& sensors) {
  return sensors.empty() || std::find(sensors.begin(), sensors.end(), sensor) != sensors.end();
}

std::string misfit(const DetectionFrame& frame, bool is_3d) {
  if (!frame.has_range) return "no range measured";
  return misfit_of_bearing(frame, is_3d);
}

std::string misfit_of_bearing(const DetectionFrame& frame, bool is_3d) {
  if (is_3d && !frame.is_3d) return "no pitch measured, but the map is in space";
  if (!is_3d && frame.is_3d) return "pitch measured, but the map is in the plane";
  if (!is_3d && is_tilted(frame.T_robot_sensor)) return "tilted sensor, but the map is a plane";
  return {};
}

ContinuousFactorPtr sighting_factor(Key pose, Key point, const DetectionFrame& frame,
                                    const Detection& detection, bool is_3d, Loss loss) {
  const MeasuredPoint measured = measured_point(detection, is_3d);
  const Noise noise = Noise::covariance(measured.covariance);
  if (is_3d) {
    const Eigen::Vector3d z = measured.z;
    if (!frame.calibrated) {
      return std::make_shared<BearingRange3>(pose, point, z, noise, to_se3(frame.T_robot_sensor),
                                             loss);
    }
    return std::make_shared<CalibratedBearingRange3>(pose, point, *frame.calibrated, z, noise,
                                                     loss);
  }
  const Eigen::Vector2d z = measured.z;
  if (!frame.calibrated) {
    return std::make_shared<BearingRange2>(pose, point, z, noise, to_se2(frame.T_robot_sensor),
                                           loss);
  }
  return std::make_shared<CalibratedBearingRange2>(pose, point, *frame.calibrated, z, noise, loss);
}

ContinuousFactorPtr bearing_factor(Key pose, Key point, const DetectionFrame& frame,
                                   const Detection& detection, bool is_3d, double extra_sigma) {
  const double extra = extra_sigma * extra_sigma;
  if (is_3d) {
    const Eigen::Matrix2d noise =
        detection.covariance.bottomRightCorner<2, 2>() + extra * Eigen::Matrix2d::Identity();
    return std::make_shared<Bearing3>(pose, point, Eigen::Vector2d(detection.yaw, detection.pitch),
                                      Noise::covariance(noise), to_se3(frame.T_robot_sensor));
  }
  return std::make_shared<Bearing2>(
      pose, point, Eigen::Matrix<double, 1, 1>(detection.yaw),
      Noise::isotropic(1, std::sqrt(detection.covariance(1, 1) + extra)),
      to_se2(frame.T_robot_sensor));
}

std::vector<bool> are_crowded(const DetectionFrame& frame) {
  const std::vector<Detection>& all = frame.detections;
  std::vector<bool> out(all.size(), false);
  if (all.size() <= kMostAlike) return out;
  const int dim = frame.is_3d ? 3 : 2;
  const auto alike = [&](const Detection& a, const Detection& b) {
    const Eigen::Array3d e(a.range - b.range, wrap_angle(a.yaw - b.yaw), a.pitch - b.pitch);
    const Eigen::Array3d variance = (a.covariance + b.covariance).diagonal();
    return (e.square() / variance).head(dim).sum() < dim;
  };
  for (std::size_t i = 0; i < all.size(); ++i) {
    std::size_t count = 0;
    for (std::size_t j = 0; j < all.size() && count <= kMostAlike + 1; ++j) {
      count += alike(all[i], all[j]) ? 1 : 0;  // itself among them
    }
    out[i] = count > kMostAlike + 1;
  }
  // What is left of a frame that is crowded is the rim of the crowd.
  const auto crowded = static_cast<std::size_t>(std::count(out.begin(), out.end(), true));
  if (2 * crowded > all.size()) out.assign(all.size(), true);
  return out;
}

double position_sigma(const Detection& d, bool is_3d) {
  const double across = d.range * d.range, level = across * std::pow(std::cos(d.pitch), 2);
  const double sum = d.covariance(0, 0) + level * d.covariance(1, 1) + across * d.covariance(2, 2);
  return std::sqrt(sum / (is_3d ? 3 : 2));
}

Eigen::Matrix3d noise_of_extent(double range, double pitch, double extent, bool is_3d) {
  Eigen::Matrix3d noise = Eigen::Matrix3d::Zero();
  if (extent == 0) return noise;
  noise(0, 0) = extent * extent;
  noise.diagonal().tail<2>() = across(range, pitch, extent * extent, is_3d);
  return noise;
}

Detection with_extent(Detection d, double extent, bool is_3d) {
  d.covariance += noise_of_extent(d.range, d.pitch, extent, is_3d);
  return d;
}

MeasuredPoint measured_point(const Detection& d, bool is_3d) {
  const Eigen::Index dim = is_3d ? 3 : 2;
  MeasuredPoint out{Eigen::Vector3d(d.range, d.yaw, d.pitch).head(dim),
                    d.covariance.topLeftCorner(dim, dim)};
  const double along = d.covariance(0, 0);
  if (d.range * d.range < kNearSigmas * kNearSigmas * along) {
    out.covariance.diagonal().tail(dim - 1) += across(d.range, d.pitch, along, is_3d).head(dim - 1);
  }
  return out;
}

Key position_key(std::int64_t id) {
  return {key_letter::kLandmark, static_cast<std::uint64_t>(id)};
}

Eigen::Vector3d sighted_point(const Eigen::Isometry3d& T_map_robot, const DetectionFrame& frame,
                              const Detection& detection) {
  const Eigen::Isometry3d T_map_sensor = compose(T_map_robot, frame.T_robot_sensor);
  return rotated(T_map_sensor, direction(detection.yaw, detection.pitch)) * detection.range +
         T_map_sensor.translation();
}

PointSighting point_sighting(const Eigen::Isometry3d& T_map_sensor, double time, const Detection& d,
                             bool is_3d) {
  PointSighting out;
  out.time = time + d.delay;
  out.point =
      rotated(T_map_sensor, direction(d.yaw, d.pitch)) * d.range + T_map_sensor.translation();
  const Eigen::Matrix3d R = T_map_sensor.linear();
  const Eigen::MatrixXd noise = measured_point(d, is_3d).covariance;
  if (is_3d) {
    Eigen::Matrix3d J;
    from_polar(Eigen::Vector3d(d.range, d.yaw, d.pitch), &J);
    out.covariance = R * J * noise * J.transpose() * R.transpose();
  } else {
    Eigen::Matrix2d J;
    from_polar(Eigen::Vector2d(d.range, d.yaw), &J);
    J = R.topLeftCorner<2, 2>() * J;
    out.covariance.topLeftCorner<2, 2>() = J * noise * J.transpose();
    out.point.z() = 0;
  }
  if (!d.velocity) return out;
  out.has_velocity = true;
  out.velocity = R * d.velocity->mean;
  out.velocity_covariance = R * d.velocity->covariance * R.transpose();
  return out;
}

}  // namespace hybrid
