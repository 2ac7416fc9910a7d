// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, the hybrid mapping authors

#include "mrpt_plugins/import/velocity_odometry.h"

#include <cmath>
#include <utility>

#include "mrpt_plugins/import/log_writer.h"

namespace hybrid {

Eigen::Vector3d OdometryWalk::variances(double way, double turn) const {
  Eigen::Vector3d out = Eigen::Array3d(along, across, heading).square() * way;
  out[2] += turning * turning * turn;
  return out;
}

VelocityOdometry::VelocityOdometry(const std::string& path,
                                   std::function<Velocity(const TextRow&)> read,
                                   const OdometryWalk& walk)
    : table_(path), read_(std::move(read)), walk_(walk) {
  advance();
}

void VelocityOdometry::advance() {
  const auto row = table_.next();
  if (!row) {
    next_.reset();
    return;
  }
  const Velocity read = read_(*row);
  if (next_ && read.time < next_->time) row->fail("time goes backwards");
  next_ = read;
}

OdometryIncrement VelocityOdometry::move_to(double time) {
  OdometryIncrement motion;
  motion.covariance = planar_to_6d(walk_.rest * walk_.rest * Eigen::Matrix3d::Identity());
  while (next_ && next_->time <= time) {
    roll(next_->time, motion);
    now_ = *next_;
    advance();
  }
  roll(time, motion);
  return motion;
}

void VelocityOdometry::roll(double time, OdometryIncrement& motion) {
  const double dt = time_ ? time - *time_ : 0.0;
  if (!time_ || dt > 0) time_ = time;
  const double d = dt * now_.forward, angle = dt * now_.turn;
  if (dt <= 0 || (d == 0 && angle == 0)) return;
  way_ += std::abs(d);
  const Eigen::Vector3d variances = walk_.variances(std::abs(d), std::abs(angle));
  // Chord of the arc, to second order in the angle.
  motion = compose(motion, planar_motion(d * std::cos(0.5 * angle), d * std::sin(0.5 * angle),
                                         angle, variances.asDiagonal()));
}

}  // namespace hybrid
