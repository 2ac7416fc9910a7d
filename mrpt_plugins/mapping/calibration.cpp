// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, the hybrid mapping authors

#include "mrpt_plugins/mapping/calibration.h"

#include <fmt/format.h>

#include <Eigen/Cholesky>
#include <Eigen/Eigenvalues>
#include <algorithm>
#include <cmath>
#include <cstdint>
#include <memory>
#include <utility>

#include "libhybrid/core/error.h"
#include "libhybrid/core/key_letters.h"
#include "libhybrid/factors/calibrated_motion.h"
#include "libhybrid/factors/prior.h"
#include "mrpt_plugins/bridge/pose_conversions.h"
#include "mrpt_plugins/bridge/poses.h"

namespace hybrid {
namespace {

constexpr double kDegree = M_PI / 180;
constexpr int kRobotShift = 32;  // of keys: a robot has fewer sensors than 2^32

/// Share of the prior variance above which a direction counts as not observed: the measurements
/// carry less information about it than the prior.
constexpr double kUnobservedShare = 0.5;
/// Least component of an entry in such a direction, in standard deviations of the prior, for which
/// the entry counts as not observed.
constexpr double kEntryCounts = 0.3;

/// Which entries have no part in a direction that the measurements do not determine.
std::vector<bool> observed(const Eigen::MatrixXd& posterior, const Eigen::VectorXd& prior_sigmas) {
  const Eigen::MatrixXd ratio = prior_sigmas.cwiseInverse().asDiagonal() * posterior *
                                prior_sigmas.cwiseInverse().asDiagonal();
  const Eigen::SelfAdjointEigenSolver<Eigen::MatrixXd> solver(ratio);
  std::vector<bool> out(static_cast<std::size_t>(posterior.rows()), true);
  for (Eigen::Index k = 0; k < ratio.rows(); ++k) {
    if (!(solver.eigenvalues()[k] > kUnobservedShare)) continue;
    for (Eigen::Index i = 0; i < ratio.rows(); ++i) {
      if (std::abs(solver.eigenvectors()(i, k)) > kEntryCounts) {
        out[static_cast<std::size_t>(i)] = false;
      }
    }
  }
  return out;
}

/// The covariance of a variable, or of its prior if the back-end has none.
Eigen::MatrixXd covariance_of(Key key, const Backend& backend, const Eigen::VectorXd& prior) {
  const Uncertainty uncertainty = backend.uncertainty({key}, {});
  const auto it = uncertainty.covariances.find(key);
  if (it != uncertainty.covariances.end()) return it->second;
  return prior.array().square().matrix().asDiagonal();
}

Eigen::VectorXd sensor_sigmas(const CalibrationOptions& options, bool is_3d) {
  Eigen::VectorXd sigmas(is_3d ? 6 : 3);
  sigmas.setConstant(options.sensor_sigma_rad);
  sigmas.head(is_3d ? 3 : 2).setConstant(options.sensor_sigma_m);
  return sigmas;
}

Eigen::VectorXd odometry_sigmas(const CalibrationOptions& options, bool is_3d) {
  Eigen::VectorXd sigmas(is_3d ? 5 : 3);
  sigmas.setConstant(options.drift_sigma);
  sigmas.head(2).setConstant(options.scale_sigma);
  return sigmas;
}

void fill(CalibrationEstimate& out, const Eigen::VectorXd& mean, const Eigen::VectorXd& start,
          const Eigen::MatrixXd& covariance, const Eigen::VectorXd& prior,
          const Eigen::VectorXd& units) {
  const std::vector<bool> seen = observed(covariance, prior);
  for (Eigen::Index i = 0; i < mean.size(); ++i) {
    CalibrationEstimate::Entry& entry = out.entries[static_cast<std::size_t>(i)];
    entry.value = mean[i] / units[i];
    entry.start = start[i] / units[i];
    entry.sigma = std::sqrt(covariance(i, i)) / units[i];
    entry.observed = seen[static_cast<std::size_t>(i)];
  }
}

std::vector<double> vector_of(const mrpt::poses::CPose3D& pose) {
  return {pose.x(), pose.y(), pose.z(), pose.yaw(), pose.pitch(), pose.roll()};
}

Eigen::VectorXd entries_of(const mrpt::poses::CPose3D& pose, bool is_3d) {
  const std::vector<double> v = vector_of(pose);
  if (is_3d) return Eigen::VectorXd::Map(v.data(), 6);
  return Eigen::Vector3d(v[0], v[1], v[3]);
}

/// Units of the entries (x y z yaw pitch roll) or (x y yaw): 1 m and 1 degree, in m and rad.
Eigen::VectorXd pose_units(bool is_3d) {
  Eigen::VectorXd units = Eigen::VectorXd::Ones(is_3d ? 6 : 3);
  units.tail(is_3d ? 3 : 1).setConstant(kDegree);
  return units;
}

}  // namespace

CalibrationOptions read_calibration_options(IniFile& ini) {
  IniSection s = ini.section("calibration", "What is estimated of the robot itself");
  CalibrationOptions options;
  options.sensor_pose = s.get("sensor_pose", false, "estimate where every sensor sits");
  const auto start =
      s.get("sensor_start", std::vector<double>{},
            "where to start, x y z [m] yaw pitch roll [deg]; empty: as the log says", kCoordinate);
  if (start.size() == 6) {
    options.sensor_start.emplace(start[0], start[1], start[2], start[3] * kDegree,
                                 start[4] * kDegree, start[5] * kDegree);
  } else if (!start.empty()) {
    s.fail("sensor_start", "needs six numbers: x y z yaw pitch roll");
  }
  s.read("sensor_sigma_m", options.sensor_sigma_m, "prior around the start [m]", kSigmaMetres);
  options.sensor_sigma_rad =
      s.degrees("sensor_sigma_deg", 60.0, "the same for the rotation", kSigmaDegrees);
  options.odometry = s.get("odometry", false, "estimate scale and drift of the odometry");
  options.odometry_start =
      s.get("odometry_start", std::vector<double>{},
            "where to start: scale of translation, scale of rotation, drift [deg/m], the drift in "
            "space about x y z; empty: 1 1 and no drift",
            kTurn);
  for (std::size_t i = 2; i < options.odometry_start.size(); ++i) {
    options.odometry_start[i] *= kDegree;
  }
  s.read("scale_sigma", options.scale_sigma, "prior around the scales", {1e-6, 10});
  options.drift_sigma =
      s.degrees("drift_sigma_deg", 30.0, "prior around the drift [deg/m]", kSigmaDegrees);
  return options;
}

Calibrator::Calibrator(const CalibrationOptions& options, bool is_3d, std::string robot,
                       std::size_t number)
    : options_(options),
      is_3d_(is_3d),
      robot_(std::move(robot)),
      number_(number),
      odometry_(key(key_letter::kOdometryCalibration, 0)) {
  const std::size_t wanted = is_3d ? 5 : 3;
  std::vector<double>& start = options_.odometry_start;
  if (start.empty()) {
    start.assign(wanted, 0.0);
    start[0] = start[1] = 1.0;
  }
  if (start.size() != wanted) {
    throw Error(
        fmt::format("[calibration] odometry_start has {} numbers, but the map is {}: give {}",
                    start.size(), is_3d ? "in space" : "in the plane", wanted));
  }
  if (options_.sensor_pose && options_.sensor_start && !is_3d &&
      is_tilted(*options_.sensor_start)) {
    throw Error("[calibration] sensor_start has pitch or roll, but the map is in the plane");
  }
}

Key Calibrator::key(char letter, std::size_t index) const {
  return {letter, (static_cast<std::uint64_t>(number_) << kRobotShift) + index};
}

std::string Calibrator::named(const std::string& what) const {
  return robot_.empty() ? what : what + " of robot " + robot_;
}

void Calibrator::place_sensors(std::vector<DetectionFrame>& frames, const Values& values,
                               Delta& delta) {
  if (!options_.sensor_pose) return;
  for (DetectionFrame& frame : frames) {
    if (!is_3d_ && is_tilted(frame.T_robot_sensor)) continue;
    auto it = sensors_.find(frame.sensor_label);
    if (it == sensors_.end()) {
      const Sensor sensor{key(key_letter::kSensorPose, sensors_.size()),
                          options_.sensor_start.value_or(to_mrpt(frame.T_robot_sensor)),
                          to_mrpt(frame.T_robot_sensor)};
      it = sensors_.emplace(frame.sensor_label, sensor).first;
    }
    const Key pose = it->second.key;
    if (!values.contains(pose) && !delta.values.contains(pose)) add_sensor(it->second, delta);
    frame.calibrated = pose;
    frame.T_robot_sensor = isometry_at(values.contains(pose) ? values : delta.values, pose);
  }
}

std::optional<Eigen::Isometry3d> Calibrator::sensor(const std::string& label,
                                                    const Values& values) const {
  const auto it = sensors_.find(label);
  if (it == sensors_.end() || !values.contains(it->second.key)) return std::nullopt;
  return isometry_at(values, it->second.key);
}

void Calibrator::add_sensor(const Sensor& sensor, Delta& delta) const {
  const Noise noise = Noise::diagonal(sensor_sigmas(options_, is_3d_));
  insert_pose(delta.values, sensor.key, sensor.start, is_3d_);
  if (is_3d_) {
    delta.continuous.push_back(
        std::make_shared<Prior<SE3>>(sensor.key, to_se3(sensor.start), noise));
  } else {
    delta.continuous.push_back(
        std::make_shared<Prior<SE2>>(sensor.key, to_se2(sensor.start), noise));
  }
}

std::optional<Key> Calibrator::odometry(const Values& values, Delta& delta) const {
  if (!options_.odometry) return std::nullopt;
  if (!values.contains(odometry_)) {
    const Noise noise = Noise::diagonal(odometry_sigmas(options_, is_3d_));
    const double* start = options_.odometry_start.data();
    if (is_3d_) {
      const OdometryCalibration3 c = Eigen::Map<const OdometryCalibration3>(start);
      delta.values.insert(odometry_, c);
      delta.continuous.push_back(
          std::make_shared<Prior<OdometryCalibration3>>(odometry_, c, noise));
    } else {
      const OdometryCalibration2 c = Eigen::Map<const OdometryCalibration2>(start);
      delta.values.insert(odometry_, c);
      delta.continuous.push_back(
          std::make_shared<Prior<OdometryCalibration2>>(odometry_, c, noise));
    }
  }
  return odometry_;
}

mrpt::poses::CPose3D Calibrator::corrected(const mrpt::poses::CPose3D& motion,
                                           const Values& values) const {
  if (!options_.odometry) return motion;
  const double* c =
      values.contains(odometry_) ? values.data(odometry_) : options_.odometry_start.data();
  if (is_3d_) {
    return to_mrpt(calibrated(to_se3(motion), Eigen::Map<const OdometryCalibration3>(c)));
  }
  return to_mrpt(calibrated(to_se2(motion), Eigen::Map<const OdometryCalibration2>(c)));
}

CalibrationEstimate Calibrator::sensor_estimate(const std::string& label, const Sensor& sensor,
                                                const Backend& backend) const {
  CalibrationEstimate out;
  out.name = named(fmt::format("pose of sensor {}", label.empty() ? "without label" : label));
  for (const char* name : {"x", "y", "z", "yaw", "pitch", "roll"}) {
    const bool angle = out.entries.size() >= (is_3d_ ? 3U : 2U);
    const std::string text = name;
    if (!is_3d_ && text != "x" && text != "y" && text != "yaw") continue;
    out.entries.push_back({text, angle ? "deg" : "m"});
  }
  const mrpt::poses::CPose3D T = pose_at(backend.values(), sensor.key);
  const Eigen::VectorXd prior = sensor_sigmas(options_, is_3d_);
  Eigen::MatrixXd covariance = covariance_of(sensor.key, backend, prior);
  if (is_3d_) {
    const Matrix6d J = euler_from_tangent(T);
    covariance = J * covariance * J.transpose();
  } else {
    Eigen::Matrix3d J = Eigen::Matrix3d::Identity();
    J.topLeftCorner<2, 2>() = to_se2(T).rotation().matrix();
    covariance = J * covariance * J.transpose();
  }
  fill(out, entries_of(T, is_3d_), entries_of(sensor.start, is_3d_), covariance, prior,
       pose_units(is_3d_));
  for (std::size_t i = 0; i < out.entries.size(); ++i) {
    out.entries[i].logged = (entries_of(sensor.logged, is_3d_).array() /
                             pose_units(is_3d_).array())[static_cast<Eigen::Index>(i)];
  }
  return out;
}

CalibrationEstimate Calibrator::odometry_estimate(const Backend& backend) const {
  CalibrationEstimate out;
  out.name = named("odometry");
  out.entries = {{"scale of translation", ""}, {"scale of rotation", ""}};
  if (is_3d_) {
    for (const char* axis : {"x", "y", "z"}) {
      out.entries.push_back({fmt::format("drift about {}", axis), "deg/m"});
    }
  } else {
    out.entries.push_back({"drift", "deg/m"});
  }
  const auto n = static_cast<Eigen::Index>(out.entries.size());
  const Eigen::VectorXd prior = odometry_sigmas(options_, is_3d_);
  Eigen::VectorXd units = Eigen::VectorXd::Ones(n);
  units.tail(n - 2).setConstant(kDegree);
  fill(out, Eigen::Map<const Eigen::VectorXd>(backend.values().data(odometry_), n),
       Eigen::Map<const Eigen::VectorXd>(options_.odometry_start.data(), n),
       covariance_of(odometry_, backend, prior), prior, units);
  return out;
}

std::vector<CalibrationEstimate> Calibrator::estimates(const Backend& backend) const {
  std::vector<CalibrationEstimate> out;
  for (const auto& [label, sensor] : sensors_) {
    if (!backend.values().contains(sensor.key)) continue;
    out.push_back(sensor_estimate(label, sensor, backend));
  }
  if (backend.values().contains(odometry_)) out.push_back(odometry_estimate(backend));
  return out;
}

}  // namespace hybrid
