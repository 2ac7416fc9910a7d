// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, the hybrid mapping authors

#include "libhybrid/detections/detection_tracker.h"

#include <Eigen/Cholesky>
#include <Eigen/LU>
#include <algorithm>
#include <cmath>
#include <utility>

#include "libhybrid/association/gate.h"
#include "libhybrid/association/matching.h"
#include "libhybrid/core/chi_square.h"
#include "libhybrid/core/infinity.h"
#include "libhybrid/core/spatial_values.h"
#include "libhybrid/discrete/class_evidence.h"
#include "libhybrid/geometry/isometry.h"
#include "libhybrid/geometry/polar.h"
#include "libhybrid/geometry/so3.h"

namespace hybrid {
namespace {

constexpr double kRest = 0.9999;  // probability with which a thing at rest is taken for one

/// Whether noise explains a velocity. What the detections have in common for all of the time does
/// not move a thing, what they have in common for a while does.
bool fits_rest(const Detection::Velocity& velocity, Eigen::Index dim, double inflation) {
  const Eigen::VectorXd v = velocity.mean.head(dim);
  const Eigen::MatrixXd C = velocity.covariance.topLeftCorner(dim, dim);
  return v.dot(C.llt().solve(v)) <=
         std::sqrt(inflation) * chi_square_quantile(kRest, static_cast<int>(dim));
}

/// Covariance of a point of a sensor that came with the robot, from that of the motion since: the
/// point is q in the frame of the robot now, and R turns from there into that of the sensor.
Eigen::MatrixXd from_motion(const Eigen::Vector3d& q, const Eigen::Matrix3d& R,
                            const SE3::Jacobian& covariance) {
  Eigen::Matrix<double, 3, 6> J;
  J << Eigen::Matrix3d::Identity(), -hat(q);
  J = R * J;
  return J * covariance * J.transpose();
}

/// Gives a detection the place p of covariance P in the frame of its sensor.
void place_at(const Eigen::VectorXd& p, const Eigen::MatrixXd& P, Detection& out) {
  if (p.size() == 2) {
    Eigen::Matrix2d J;
    const Eigen::Vector2d z = to_polar(Eigen::Vector2d(p), &J);
    out.range = z[0];
    out.yaw = z[1];
    out.covariance.topLeftCorner<2, 2>() = J * P * J.transpose();
  } else {
    Eigen::Matrix3d J;
    const Eigen::Vector3d z = to_polar(Eigen::Vector3d(p), &J);
    out.range = z[0];
    out.yaw = z[1];
    out.pitch = z[2];
    out.covariance = J * P * J.transpose();
  }
}

}  // namespace

void DetectionTracker::Track::take(const Eigen::VectorXd& point, const Eigen::MatrixXd& covariance,
                                   double t) {
  const Eigen::MatrixXd W = covariance.inverse();
  information += W;
  information_mean += W * point;
  information_time += t * W;
  information_time2 += t * t * W;
  information_mean_time += t * W * point;
  seconds += t;
}

std::optional<Detection::Velocity> DetectionTracker::Track::velocity() const {
  if (members.size() < kFewestForMotion) return std::nullopt;
  const Eigen::MatrixXd gain = information_time * covariance();
  const Eigen::MatrixXd of_motion = information_time2 - gain * information_time;
  const Eigen::LLT<Eigen::MatrixXd> llt(of_motion);
  constexpr double kLeast = 1e-9;  // of the spread of times that is not rounding, as a share
  const auto dim = of_motion.rows();
  if (llt.info() != Eigen::Success) return std::nullopt;
  if (!(of_motion.trace() > kLeast * information_time2.trace())) return std::nullopt;
  Detection::Velocity out;
  out.mean.head(dim) = llt.solve(information_mean_time - gain * information_mean);
  out.covariance.topLeftCorner(dim, dim) = llt.solve(Eigen::MatrixXd::Identity(dim, dim));
  return out;
}

void DetectionTracker::move(const Eigen::Isometry3d& motion, const SE3::Jacobian& covariance) {
  const SE3::Jacobian Ad = adjoint(between(motion, Eigen::Isometry3d::Identity()));
  for (auto& [label, sensor] : sensors_) {
    sensor.T_now_first = between(motion, sensor.T_now_first);
    sensor.T_then_now = compose(sensor.T_then_now, motion);
    sensor.motion_covariance = Ad * sensor.motion_covariance * Ad.transpose() + covariance;
    sensor.reach = std::max(sensor.reach, sensor.T_then_now.translation().norm());
    ++sensor.frames;
  }
}

/// Where a detection puts its thing in the frame of the sensor at its first frame.
DetectionTracker::Seen DetectionTracker::place(const Sensor& sensor, const DetectionFrame& frame,
                                               const Detection& d) {
  const Eigen::Isometry3d T = between(sensor.T_now_first, frame.T_robot_sensor);
  const Eigen::Matrix3d R = T.linear();
  const Eigen::Vector3d t = T.translation();
  if (frame.is_3d) {
    Eigen::Matrix3d J;
    const Eigen::Vector3d p = from_polar(Eigen::Vector3d(d.range, d.yaw, d.pitch), &J);
    return {R * p + t, R * J * d.covariance * J.transpose() * R.transpose()};
  }
  Eigen::Matrix2d J;
  const Eigen::Vector2d p = from_polar(Eigen::Vector2d(d.range, d.yaw), &J);
  J = R.topLeftCorner<2, 2>() * J;
  return {R.topLeftCorner<2, 2>() * p + t.head<2>(),
          J * d.covariance.topLeftCorner<2, 2>() * J.transpose()};
}

/// The track that each detection continues, -1 for none.
std::vector<int> DetectionTracker::match(const Sensor& sensor, const std::vector<Seen>& seen,
                                         const std::vector<Detection>& detections) const {
  const auto rows = static_cast<Eigen::Index>(seen.size());
  const auto cols = static_cast<Eigen::Index>(sensor.tracks.size());
  MatchingProblem problem;
  problem.matched.setConstant(rows, cols, kInfinity);
  double worst = 0;
  for (Eigen::Index j = 0; j < cols; ++j) {
    const Track& track = sensor.tracks[static_cast<std::size_t>(j)];
    const Eigen::MatrixXd P = track.covariance();
    const Eigen::VectorXd mean = P * track.information_mean;
    for (Eigen::Index i = 0; i < rows; ++i) {
      const Detection& d = detections[static_cast<std::size_t>(i)];
      const Seen& at = seen[static_cast<std::size_t>(i)];
      if (d.id != track.id) continue;
      const GaussianScore score = gaussian_score(at.point - mean, P + at.covariance);
      const bool near =
          score.chi_square <= chi_square_quantile(options_.gate, static_cast<int>(mean.size()));
      if (!d.id && !near) continue;
      problem.matched(i, j) =
          d.id ? 0.0 : score.cost + class_disagreement(d.class_probabilities, track.class_evidence);
      worst = std::max(worst, std::abs(problem.matched(i, j)));
    }
  }
  problem.unmatched.setConstant(rows, static_cast<double>(rows) * 2 * worst + 1);
  return best_matching(problem).column;
}

void DetectionTracker::take(const DetectionFrame& frame) {
  const auto [it, is_new] = sensors_.try_emplace(frame.sensor_label);
  Sensor& sensor = it->second;
  if (is_new) {
    sensor.first = frame;
    sensor.first.detections.clear();
    sensor.T_now_first = frame.T_robot_sensor;
    const auto before = last_times_.find(frame.sensor_label);
    if (before != last_times_.end()) sensor.interval = frame.time - before->second;
  }
  const double seconds = frame.time - sensor.first.time;
  sensor.seconds = std::max(sensor.seconds, std::abs(seconds));
  std::vector<Seen> seen;
  for (const Detection& d : frame.detections) seen.push_back(place(sensor, frame, d));
  const std::vector<int> column = match(sensor, seen, frame.detections);
  for (std::size_t i = 0; i < seen.size(); ++i) {
    const Detection& d = frame.detections[i];
    const auto dim = seen[i].point.size();
    if (column[i] < 0) {
      const Eigen::MatrixXd zero = Eigen::MatrixXd::Zero(dim, dim);
      const Eigen::VectorXd none = Eigen::VectorXd::Zero(dim);
      sensor.tracks.push_back({zero, none, zero, zero, none, d.id, {}, {}, 0, 0});
    }
    Track& track =
        column[i] < 0 ? sensor.tracks.back() : sensor.tracks[static_cast<std::size_t>(column[i])];
    track.take(seen[i].point, seen[i].covariance, seconds);
    track.steps += sensor.frames;
    track.members.push_back(d.true_id);
    add_class_scores(d.class_probabilities, track.class_evidence);
  }
}

/// How many times in a row a sensor hands on what its detections of a thing have in common.
double DetectionTracker::repetitions(const Sensor& sensor) const {
  const double frames = sensor.frames > 0 ? sensor.frames : 1;
  const double interval = sensor.interval.value_or(sensor.seconds * (1 + 1 / frames));
  return interval > 0 ? std::max(1.0, options_.lasts / interval) : 1.0;
}

Detection DetectionTracker::detection_of(const Sensor& sensor, const Track& track) const {
  const double n = static_cast<double>(track.members.size());
  const Eigen::VectorXd p = track.mean();
  const auto dim = p.size();
  // n alike detections whose noise is in part common to all: 1/n of one part, all of the other.
  const double common = inflation(track);
  const double repeated = options_.common * n * (repetitions(sensor) - 1);
  Eigen::MatrixXd P = track.covariance() * (common + repeated);
  const double rest = sensor.frames > 0 ? 1 - track.steps / n / sensor.frames : 0.0;
  const Eigen::Matrix3d R = sensor.T_now_first.linear();
  const Eigen::Vector3d first = padded_point(p);
  const Eigen::Vector3d now = R.col(0) * first.x() + R.col(1) * first.y() + R.col(2) * first.z() +
                              sensor.T_now_first.translation();
  const Eigen::MatrixXd drift =
      from_motion(now, R.transpose(), sensor.motion_covariance).topLeftCorner(dim, dim);
  P += rest * drift;
  Detection out;
  out.id = track.id;
  out.members = track.members;
  out.delay = track.seconds / n;
  out.velocity = track.velocity();
  out.at_rest = track.id.has_value() || !out.velocity || fits_rest(*out.velocity, dim, common);
  if (out.velocity) {  // what detections have in common for a while is motion to them
    out.velocity->covariance *= common;
    out.velocity->covariance.topLeftCorner(dim, dim) += drift / (sensor.seconds * sensor.seconds);
  }
  place_at(p, P, out);
  out.class_probabilities = class_probabilities(track.class_evidence, common);
  return out;
}

std::vector<DetectionFrame> DetectionTracker::release() {
  std::vector<DetectionFrame> out;
  for (auto& [label, sensor] : sensors_) {
    last_times_[label] = sensor.first.time;
    DetectionFrame frame = std::move(sensor.first);
    frame.T_robot_sensor = sensor.T_now_first;
    if (frame.max_range > 0) frame.max_range += sensor.reach;
    for (const Track& track : sensor.tracks) {
      frame.detections.push_back(detection_of(sensor, track));
    }
    out.push_back(std::move(frame));
  }
  sensors_.clear();
  return out;
}

std::size_t DetectionTracker::forget() {
  std::size_t lost = 0;
  for (const auto& [label, sensor] : sensors_) {
    for (const Track& track : sensor.tracks) lost += track.members.size();
  }
  sensors_.clear();
  return lost;
}

}  // namespace hybrid
