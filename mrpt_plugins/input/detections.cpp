// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, the hybrid mapping authors

#include "mrpt_plugins/input/detections.h"

#include <mrpt/math/wrap2pi.h>
#include <mrpt/obs/CObservationBearingRange.h>
#include <mrpt/system/datetime.h>

#include <Eigen/Cholesky>
#include <algorithm>
#include <cmath>
#include <numeric>
#include <set>

#include "mrpt_plugins/bridge/pose_conversions.h"
#include "mrpt_plugins/bridge/poses.h"
#include "mrpt_plugins/mrpt_version.h"
#include "mrpt_plugins/observations/classed_bearing_range.h"

namespace hybrid {
namespace {

using mrpt::obs::CObservationBearingRange;
using mrpt::obs::INVALID_LANDMARK_ID;

/// Why a sensor pose is implausible, or null: sensors are nearer to the robot than their range.
const char* fault(const mrpt::poses::CPose3D& T_robot_sensor, const DetectionOptions& options) {
  const bool is_finite = std::isfinite(T_robot_sensor.norm()) &&
                         T_robot_sensor.getRotationMatrix().asEigen().allFinite();
  if (!is_finite) return "observation dropped: sensor pose not finite";
  const bool is_plausible =
      T_robot_sensor.norm() <= options.max_range && is_rotation(T_robot_sensor);
  return is_plausible ? nullptr : "observation dropped: sensor pose absurd";
}

/// Smaller sigmas [m, rad] are no sensor's and come from damage: their inverse squares would
/// outweigh all other measurements.
constexpr double kLeastSigma = 1e-6;

/// Sigmas of noise by which a measurement may exceed the limits of its sensor.
constexpr double kLimitSigmas = 5;

/// Why the range is outside the limits of the sensor, or null.
const char* range_fault(const Detection& d, const DetectionFrame& frame,
                        const DetectionOptions& options) {
  if (d.range > options.max_range) return "detection dropped: range above limit";
  if (!frame.has_range) return nullptr;
  if (d.range <= 0) return "detection dropped: range not positive";
  const double noise = kLimitSigmas * std::sqrt(std::max(0.0, d.covariance(0, 0)));
  const bool is_limited = std::isfinite(frame.max_range) && frame.max_range > 0;
  if (is_limited && d.range > frame.max_range + noise) {
    return "detection dropped: range above that of the sensor";
  }
  return nullptr;
}

/// Whether the sigmas are small enough for the detection to carry information.
bool tells_something(const Detection& d, const DetectionOptions& options) {
  const Eigen::Vector3d variances = d.covariance.diagonal();
  return variances[0] <= options.max_range * options.max_range &&
         variances.tail<2>().maxCoeff() <= M_PI * M_PI;
}

/// Why a measurement is unusable, or null. Wraps the yaw.
const char* fault(Detection& d, const DetectionFrame& frame, const DetectionOptions& options) {
  constexpr double kMaxPitch = M_PI_2 + 1e-6;
  if (!std::isfinite(d.range)) return "detection dropped: range not finite";
  if (!std::isfinite(d.yaw)) return "detection dropped: yaw not finite";
  if (!std::isfinite(d.pitch)) return "detection dropped: pitch not finite";
  if (const char* reason = range_fault(d, frame, options)) return reason;
  if (std::abs(d.yaw) > 2 * M_PI) return "detection dropped: yaw absurd";
  if (std::abs(d.pitch) > kMaxPitch) return "detection dropped: pitch absurd";
  d.yaw = mrpt::math::wrapToPi(d.yaw);
  const double noise = kLimitSigmas * std::sqrt(std::max(0.0, d.covariance(1, 1)));
  if (frame.fov_yaw > 0 && std::abs(d.yaw) > 0.5 * frame.fov_yaw + noise) {
    return "detection dropped: outside the field of view";
  }
  return tells_something(d, options) ? nullptr : "detection dropped: sigma absurd";
}

double sigma_or_default(double chosen, double logged, double fallback, DropReport& report) {
  if (chosen > 0) return chosen;
  if (std::isfinite(logged) && logged >= kLeastSigma) return logged;
  ++report["sigma repaired: not positive, default taken"];
  return fallback;
}

/// `logged` are the sigmas of range, yaw and pitch.
template <class Observation>
Eigen::Matrix3d sensor_covariance(const Observation& from, const Eigen::Vector3f& logged,
                                  bool is_3d, const DetectionOptions& options, DropReport& report) {
  if (from.empty()) return Eigen::Matrix3d::Zero();
  const double r =
      sigma_or_default(options.sigma_range, logged[0], options.default_sigma_range, report);
  const double y =
      sigma_or_default(options.sigma_yaw, logged[1], options.default_sigma_angle, report);
  const double p = !is_3d ? 0.0
                          : sigma_or_default(options.sigma_pitch, logged[2],
                                             options.default_sigma_angle, report);
  return Eigen::Vector3d(r * r, y * y, p * p).asDiagonal();
}

bool positive_definite(const Eigen::Matrix3d& covariance, bool is_3d) {
  if (!covariance.allFinite() || !covariance.isApprox(covariance.transpose(), 1e-6)) return false;
  const Eigen::Index measured = is_3d ? 3 : 2;
  if (covariance.diagonal().head(measured).minCoeff() < kLeastSigma * kLeastSigma) return false;
  if (!is_3d) return covariance.topLeftCorner<2, 2>().llt().info() == Eigen::Success;
  return covariance.llt().info() == Eigen::Success;
}

/// The covariance of one detection. Its own sigmas replace those of the sensor, unless the options
/// set sigmas.
Eigen::Matrix3d own_covariance(const CObservationClassedBearingRange::Detection& d,
                               Eigen::Matrix3d covariance, bool is_3d,
                               const DetectionOptions& options) {
  const auto take = [&](int i, double chosen, float own) {
    if (chosen <= 0 && std::isfinite(own) && own >= kLeastSigma)
      covariance(i, i) = double{own} * own;
  };
  take(0, options.sigma_range, d.std_range);
  take(1, options.sigma_yaw, d.std_yaw);
  if (is_3d) take(2, options.sigma_pitch, d.std_pitch);
  return covariance;
}

/// Sets the id by its source, and the true id to that of the sensor if there is no other. Ids of
/// robots stay.
void choose_ids(const DetectionOptions& options, Detection& d) {
  if (!d.true_id) d.true_id = d.id;
  if (d.id && options.robots.count(*d.id) != 0) return;
  if (options.ids == IdSource::kNone) d.id.reset();
  if (options.ids == IdSource::kTruth) d.id = d.true_id;
}

std::optional<std::int64_t> id_of(std::int32_t id, const DetectionOptions& options,
                                  DropReport& report) {
  if (id >= 0 || options.robots.count(id) != 0) return id;
  if (id != INVALID_LANDMARK_ID) ++report["id repaired: negative, taken as none"];
  return std::nullopt;
}

std::vector<double> probabilities(const std::vector<float>& scores, std::size_t classes,
                                  const DetectionOptions& options, DropReport& report) {
  if (scores.empty()) return {};
  if (scores.size() != classes) {
    ++report["class scores removed: wrong length"];
    return {};
  }
  const bool valid =
      std::all_of(scores.begin(), scores.end(), [](float s) { return std::isfinite(s) && s >= 0; });
  const double sum = std::accumulate(scores.begin(), scores.end(), 0.0);
  if (!valid || sum <= 0) {
    ++report[valid ? "class scores removed: all zero"
                   : "class scores removed: negative or not finite"];
    return {};
  }
  if (std::abs(sum - 1) > options.sum_tolerance) ++report["class scores repaired: normalised"];
  std::vector<double> result(scores.begin(), scores.end());
  for (double& p : result) p /= sum;
  return result;
}

/// Appends `d` unless it is unusable or its id is already in the frame.
void add_if_usable(Detection d, const DetectionOptions& options, std::set<std::int64_t>& seen,
                   DetectionFrame& frame, DropReport& report) {
  if (!frame.is_3d) d.pitch = 0;
  if (!frame.has_range) d.range = 0;
  choose_ids(options, d);
  if (const char* reason = fault(d, frame, options)) {
    ++report[reason];
  } else if (d.id && !seen.insert(*d.id).second) {
    ++report["detection dropped: id twice in one observation"];
  } else if (!positive_definite(d.covariance, frame.is_3d)) {
    ++report["detection dropped: covariance not positive definite"];
  } else {
    frame.detections.push_back(std::move(d));
  }
}

bool measures_pitch(const CObservationBearingRange& observation) {
  const auto has_pitch = [&](const auto& m) {
    return m.pitch != 0 || (observation.validCovariances && m.covariance(2, 2) > 0);
  };
  return (!observation.validCovariances && observation.sensor_std_pitch > 0) ||
         std::any_of(observation.sensedData.begin(), observation.sensedData.end(), has_pitch);
}

DetectionFrame read(const CObservationBearingRange& observation, const DetectionOptions& options,
                    DropReport& report) {
  DetectionFrame frame;
  frame.T_robot_sensor = to_isometry(observation.sensorLocationOnRobot);
  frame.is_3d = measures_pitch(observation);
  frame.min_range = observation.minSensorDistance;
  frame.max_range = observation.maxSensorDistance;
  frame.fov_yaw = observation.fieldOfView_yaw;
  frame.fov_pitch = observation.fieldOfView_pitch;
  Eigen::Matrix3d common = Eigen::Matrix3d::Zero();
  if (!observation.validCovariances) {
    common = sensor_covariance(
        observation.sensedData,
        {observation.sensor_std_range, observation.sensor_std_yaw, observation.sensor_std_pitch},
        frame.is_3d, options, report);
  }
  std::set<std::int64_t> seen;
  for (const auto& m : observation.sensedData) {
    Detection d{m.range, m.yaw, m.pitch, id_of(m.landmarkID, options, report), {}, {}, common};
    if (observation.validCovariances) d.covariance = m.covariance.asEigen();
    if (!frame.is_3d) {
      d.covariance.row(2).setZero();
      d.covariance.col(2).setZero();
    }
    add_if_usable(std::move(d), options, seen, frame, report);
  }
  return frame;
}

DetectionFrame read(const CObservationClassedBearingRange& observation,
                    const DetectionOptions& options, DropReport& report) {
  DetectionFrame frame;
  frame.T_robot_sensor = to_isometry(observation.sensor_pose);
  frame.is_3d = observation.has_pitch;
  frame.has_range = observation.has_range;
  frame.min_range = observation.min_range;
  frame.max_range = observation.max_range;
  frame.fov_yaw = observation.fov_yaw;
  frame.fov_pitch = observation.fov_pitch;
  frame.class_names = observation.class_names;
  const Eigen::Matrix3d covariance = sensor_covariance(
      observation.detections,
      {frame.has_range ? observation.std_range : 1.0F, observation.std_yaw, observation.std_pitch},
      frame.is_3d, options, report);
  std::set<std::int64_t> seen;
  for (const auto& m : observation.detections) {
    std::optional<std::int64_t> true_id;
    if (m.true_landmark_id >= 0) true_id = m.true_landmark_id;
    add_if_usable({m.range, m.yaw, m.pitch, id_of(m.landmark_id, options, report), true_id,
                   probabilities(m.class_scores, frame.class_names.size(), options, report),
                   own_covariance(m, covariance, frame.is_3d, options)},
                  options, seen, frame, report);
  }
  return frame;
}

}  // namespace

std::optional<DetectionFrame> detections_in(const mrpt::obs::CObservation& observation,
                                            const DetectionOptions& options, DropReport& report) {
  std::optional<DetectionFrame> frame;
  if (const auto* plain = dynamic_cast<const CObservationBearingRange*>(&observation)) {
    frame = read(*plain, options, report);
  } else if (const auto* classed =
                 dynamic_cast<const CObservationClassedBearingRange*>(&observation)) {
    frame = read(*classed, options, report);
  } else {
    return std::nullopt;
  }
  if (const char* reason = fault(to_mrpt(frame->T_robot_sensor), options)) {
    ++report[reason];
    return std::nullopt;
  }
  if (observation.timestamp != INVALID_TIMESTAMP) {
    frame->time = seconds_of(observation.timestamp);
  }
  frame->sensor_label = observation.sensorLabel;
  return frame;
}

}  // namespace hybrid
