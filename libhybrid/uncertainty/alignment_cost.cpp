// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, the hybrid mapping authors
#include "libhybrid/uncertainty/detail/alignment_cost.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include "libhybrid/geometry/polar.h"
#include "libhybrid/geometry/so2.h"

namespace hybrid {
namespace {

constexpr double kLongestApart = 1;             // s, between two frames of a pair
constexpr double kStretch = 2 * kLongestApart;  // s, beyond which pairs have no frame in common
constexpr double kNudge = 1e-4;                 // rad, rad/s, for derivatives
// s, for those by the delay, both ways: odometry is a random walk, whose steps would make up those
// over a shorter time; both ways they cancel out.
constexpr double kDelayNudge = 0.25;

AlignedFrame frame_of(const TimedSightings& sightings) {
  AlignedFrame out{sightings.time, sightings.T_robot_sensor, {}};
  for (std::size_t i = 0; i < sightings.seen.size(); ++i) {
    const MeasuredPoint& m = sightings.seen[i];
    AlignedSighting seen;
    seen.z.setZero();
    seen.variance.setOnes();
    const Eigen::Index dim = m.z.size();
    seen.z.head(dim) = m.z;
    seen.point = from_polar(seen.z);
    seen.mirrored = {seen.point.x(), -seen.point.y(), seen.point.z()};
    // Only the shares of range and angles in the distance count, not its scale.
    const double r = std::max(1e-3, seen.z[0]);
    const Eigen::VectorXd stated = m.covariance.diagonal();
    seen.variance = stated.minCoeff() > 0
                        ? (Eigen::Vector3d() << stated, Eigen::VectorXd::Ones(3 - dim)).finished()
                        : Eigen::Vector3d(1, 1 / (r * r), 1 / (r * r));
    out.seen.push_back(seen);
  }
  return out;
}

}  // namespace

AlignmentCost::AlignmentCost(const std::vector<OdometryPose>& odometry,
                             const std::vector<TimedSightings>& sightings, double longest_delay)
    : odometry_(odometry) {
  for (const TimedSightings& s : sightings) {
    const bool has_odometry = !odometry.empty() &&
                              s.time - longest_delay >= odometry.front().time &&
                              s.time + longest_delay <= odometry.back().time;
    if (!s.seen.empty() && has_odometry) frames_.push_back(frame_of(s));
  }
  std::size_t first = 0;
  for (std::size_t j = 1; j < frames_.size(); ++j) {
    while (first + 1 < j && frames_[j].time - frames_[first].time > kLongestApart) ++first;
    const double apart = frames_[j].time - frames_[first].time;
    if (apart > 0 && apart <= 5 * kLongestApart) pairs_.push_back({first, j});
  }
}

void AlignmentCost::limit(double comparisons) {
  double sum = 0;
  for (const FramePair& p : pairs_) sum += comparisons_of(p);
  stride_ = static_cast<std::size_t>(std::ceil(std::max(1.0, sum / comparisons)));
}

std::array<std::vector<double>, kAlignmentParts> AlignmentCost::distances(
    const AlignmentChange& change) const {
  std::array<std::vector<double>, kAlignmentParts> out;
  for (std::size_t k = 0; k < pairs_.size(); k += stride_) {
    const AlignedFrame &a = frames_[pairs_[k].first], &b = frames_[pairs_[k].second];
    const SE3 T_b_a = motion_of(a, b, change);
    for (const AlignedSighting& s : a.seen) {
      const auto [t, distance] = nearest_to(s, b, T_b_a, change.mirrored);
      if (t != nullptr) out[k * kAlignmentParts / pairs_.size()].push_back(distance);
    }
  }
  return out;
}

PartCosts AlignmentCost::costs(const AlignmentChange& change, double scale) const {
  PartCosts out = PartCosts::Zero();
  const auto all = distances(change);
  for (std::size_t part = 0; part < kAlignmentParts; ++part) {
    for (const double d : all[part]) out[static_cast<Eigen::Index>(part)] += std::log1p(d / scale);
  }
  return out;
}

std::vector<double> AlignmentCost::costs_by_stretch(const AlignmentChange& change,
                                                    double scale) const {
  std::vector<double> out;
  double begin = -std::numeric_limits<double>::infinity();
  for (std::size_t k = 0; k < pairs_.size(); k += stride_) {
    const AlignedFrame &a = frames_[pairs_[k].first], &b = frames_[pairs_[k].second];
    if (b.time - begin > kStretch) {
      begin = b.time;
      out.push_back(0);
    }
    const SE3 T_b_a = motion_of(a, b, change);
    for (const AlignedSighting& s : a.seen) {
      const auto [t, distance] = nearest_to(s, b, T_b_a, change.mirrored);
      if (t != nullptr) out.back() += std::log1p(distance / scale);
    }
  }
  return out;
}

std::array<AlignmentSystem, kAlignmentParts> AlignmentCost::linearize(const AlignmentChange& change,
                                                                      double scale) const {
  std::array<AlignmentSystem, kAlignmentParts> out;
  AlignmentChange yaw = change, drift = change, earlier = change, later = change;
  yaw.yaw += kNudge;
  drift.drift += kNudge;
  earlier.delay -= kDelayNudge;
  later.delay += kDelayNudge;
  for (std::size_t k = 0; k < pairs_.size(); k += stride_) {
    const AlignedFrame &a = frames_[pairs_[k].first], &b = frames_[pairs_[k].second];
    const SE3 T_b_a = motion_of(a, b, change);
    const SE3 T_yaw = motion_of(a, b, yaw), T_drift = motion_of(a, b, drift);
    const SE3 T_earlier = motion_of(a, b, earlier), T_later = motion_of(a, b, later);
    AlignmentSystem& part = out[k * kAlignmentParts / pairs_.size()];
    for (const AlignedSighting& s : a.seen) {
      const std::pair<const AlignedSighting*, double> nearest =
          nearest_to(s, b, T_b_a, change.mirrored);
      const AlignedSighting* t = nearest.first;
      if (t == nullptr) continue;
      const double far = 1 + nearest.second / scale;
      const Eigen::Vector3d weights =
          (scale * far * far * (s.variance + t->variance)).cwiseInverse();
      const Eigen::Vector3d e = innovation(s, *t, T_b_a, change.mirrored);
      const auto derivative = [&](const SE3& T_1, const Eigen::Vector3d& e_0, double step) {
        Eigen::Vector3d d = innovation(s, *t, T_1, change.mirrored) - e_0;
        d[1] = wrap_angle(d[1]);
        return Eigen::Vector3d(d / step);
      };
      Eigen::Matrix3d J;
      J << derivative(T_yaw, e, kNudge),
          derivative(T_later, innovation(s, *t, T_earlier, change.mirrored), 2 * kDelayNudge),
          derivative(T_drift, e, kNudge);
      const Eigen::Matrix3d H = J.transpose() * weights.asDiagonal() * J;
      const Eigen::Vector3d g = J.transpose() * weights.asDiagonal() * e;
      part.H += H;
      part.true_H += H - 4 * far * g * g.transpose();  // the weights fall
      part.g += g;
    }
  }
  return out;
}

std::pair<double, double> AlignmentCost::motion() const {
  std::vector<double> shifts, turns;
  for (const FramePair& p : pairs_) {
    const SE3 moved = pose_at(odometry_, frames_[p.first].time)
                          .between(pose_at(odometry_, frames_[p.second].time));
    shifts.push_back(moved.translation().norm());
    turns.push_back(moved.log().tail<3>().norm());
  }
  return {upper(shifts), upper(turns)};
}

double AlignmentCost::upper(std::vector<double> values) {
  if (values.empty()) return 0;
  const auto at = values.begin() + static_cast<std::ptrdiff_t>(9 * values.size() / 10);
  std::nth_element(values.begin(), at, values.end());
  return *at;
}

double AlignmentCost::comparisons_of(const FramePair& p) const {
  return static_cast<double>(frames_[p.first].seen.size()) *
         static_cast<double>(frames_[p.second].seen.size());
}

SE3 AlignmentCost::sensor_at(const AlignedFrame& frame, const AlignmentChange& change) const {
  const SE3 turn(Eigen::Vector3d::Zero(), SO3::exp({0, 0, change.yaw}));
  const SE3 robot = pose_at(odometry_, frame.time - change.delay);
  return SE3(change.length * robot.translation(), robot.rotation()) * frame.T_robot_sensor * turn;
}

SE3 AlignmentCost::motion_of(const AlignedFrame& a, const AlignedFrame& b,
                             const AlignmentChange& change) const {
  const SE3 drift(Eigen::Vector3d::Zero(), SO3::exp({0, 0, change.drift * (a.time - b.time)}));
  return (sensor_at(b, change) * drift).between(sensor_at(a, change));
}

Eigen::Vector3d AlignmentCost::expected_of(const AlignedSighting& s, const SE3& T_b_a,
                                           bool mirrored) {
  Eigen::Vector3d z = to_polar(Eigen::Vector3d(T_b_a * (mirrored ? s.mirrored : s.point)));
  if (mirrored) z[1] = -z[1];
  return z;
}

Eigen::Vector3d AlignmentCost::innovation(const AlignedSighting& s, const AlignedSighting& t,
                                          const SE3& T_b_a, bool mirrored) {
  Eigen::Vector3d e = t.z - expected_of(s, T_b_a, mirrored);
  e[1] = wrap_angle(e[1]);
  return e;
}

std::pair<const AlignedSighting*, double> AlignmentCost::nearest_to(const AlignedSighting& s,
                                                                    const AlignedFrame& b,
                                                                    const SE3& T_b_a,
                                                                    bool mirrored) {
  const Eigen::Vector3d expected = expected_of(s, T_b_a, mirrored);
  std::pair<const AlignedSighting*, double> out{nullptr, std::numeric_limits<double>::infinity()};
  for (const AlignedSighting& t : b.seen) {
    Eigen::Array3d e = t.z - expected;
    e[1] = wrap_angle(e[1]);
    const double distance = (e * e / (s.variance + t.variance).array()).sum();
    if (distance < out.second) out = {&t, distance};
  }
  return out;
}

}  // namespace hybrid
