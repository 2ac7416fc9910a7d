// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, the hybrid mapping authors

#include "mrpt_plugins/input/poses_between.h"

#include <utility>

namespace hybrid {

Eigen::Isometry3d blend(const Eigen::Isometry3d& from, const Eigen::Isometry3d& to, double part) {
  const Eigen::Isometry3d motion = from.inverse() * to;
  const Eigen::AngleAxisd turn(motion.linear());
  Eigen::Isometry3d share = Eigen::Isometry3d::Identity();
  share.linear() = Eigen::AngleAxisd(part * turn.angle(), turn.axis()).toRotationMatrix();
  share.translation() = part * motion.translation();
  return from * share;
}

void PosesBetween::add(double time, const Eigen::Isometry3d& T_odometry_robot) {
  if (!readings_.empty() && time <= readings_.back().time) return;
  if (step_ && time <= step_->time) return;
  if (read_++ % stride_ != 0) return;
  readings_.push_back({time, T_odometry_robot});
  if (readings_.size() <= kMost) return;
  stride_ *= 2;
  std::deque<PoseBetween> kept;
  for (std::size_t i = 0; i < readings_.size(); i += 2) kept.push_back(readings_[i]);
  readings_ = std::move(kept);
}

std::vector<PoseBetween> PosesBetween::to(double time, const Eigen::Isometry3d& T_odometry_step) {
  std::vector<PoseBetween> out;
  const Eigen::Isometry3d T_step_odometry = T_odometry_step.inverse();
  while (!readings_.empty() && readings_.front().time <= time) {
    const PoseBetween& reading = readings_.front();
    if (step_) out.push_back({reading.time, T_step_odometry * reading.T_pose_robot});
    readings_.pop_front();
  }
  step_ = {time, T_odometry_step};
  read_ = 0;
  stride_ = 1;
  return out;
}

void PosesBetween::lose(double time) {
  while (!readings_.empty() && readings_.front().time <= time) readings_.pop_front();
  step_.reset();
}

std::vector<PoseBetween> PosesBetween::rest() const {
  std::vector<PoseBetween> out;
  if (!step_) return out;
  const Eigen::Isometry3d T_step_odometry = step_->T_pose_robot.inverse();
  for (const PoseBetween& reading : readings_) {
    out.push_back({reading.time, T_step_odometry * reading.T_pose_robot});
  }
  return out;
}

}  // namespace hybrid
