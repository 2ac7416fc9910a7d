// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, the hybrid mapping authors

#include "mrpt_plugins/mapping/scan_archive.h"

#include "mrpt_plugins/bridge/pose_conversions.h"

namespace hybrid {
namespace {

std::size_t bytes_of(const LaserScan& scan) {
  return scan.ranges.size() * sizeof(float);
}

bool is_at_keyframe(const LaserScan& scan) {
  return scan.T_keyframe_robot.matrix().isIdentity(0);
}

/// Share `part` of the way from the identity to a motion.
Eigen::Isometry3d part_of_motion(const Eigen::Isometry3d& motion, double part) {
  const Eigen::AngleAxisd turn(motion.linear());
  Eigen::Isometry3d out = Eigen::Isometry3d::Identity();
  out.linear() = Eigen::AngleAxisd(part * turn.angle(), turn.axis()).toRotationMatrix();
  out.translation() = part * motion.translation();
  return out;
}

}  // namespace

void ScanArchive::add(std::size_t number, const Keyframe& keyframe) {
  Step step{keyframe.robot, entries_.size(), std::nullopt};
  if (keyframe.odometry) step.T_before_keyframe = to_isometry(keyframe.odometry->mean);
  steps_.push_back(step);
  for (const LaserScan& scan : keyframe.scans) {
    entries_.push_back({number, is_at_keyframe(scan), scan});
    ranges_ += bytes_of(scan);
  }
  if (ranges_ > budget_) thin_out();
}

void ScanArchive::thin_out() {
  while (ranges_ > budget_ / 2) {
    if (!give_up_every_second(false) && !give_up_every_second(true)) return;
  }
}

/// Gives up the ranges of every second scan that still has some, of those at keyframes or of the
/// others; returns whether there were any.
bool ScanArchive::give_up_every_second(bool own) {
  bool keeps = true, any = false;
  for (Entry& entry : entries_) {
    if (entry.is_own != own || entry.scan.ranges.empty()) continue;
    if (!keeps) {
      ranges_ -= bytes_of(entry.scan);
      entry.scan.ranges = {};
      ++given_up_;
      any = true;
    }
    keeps = !keeps;
  }
  return any;
}

std::size_t ScanArchive::end_of(std::size_t step) const {
  return step + 1 < steps_.size() ? steps_[step + 1].first : entries_.size();
}

Trajectory ScanArchive::path(const Trajectory& keyframes, std::size_t robot) const {
  Trajectory out;
  std::optional<std::size_t> before;
  for (std::size_t k = 0; k < steps_.size(); ++k) {
    const Step& step = steps_[k];
    if (step.robot != robot) continue;
    const Eigen::Isometry3d T_map_keyframe = to_isometry(keyframes[k].pose);
    for (std::size_t i = step.first; i < end_of(k); ++i) {
      const Entry& entry = entries_[i];
      const double time = entry.scan.time;
      const bool is_between = time < keyframes[k].time && (out.empty() || time > out.back().time);
      if (entry.is_own || !is_between) continue;
      const Eigen::Isometry3d by_next = T_map_keyframe * entry.scan.T_keyframe_robot;
      if (!before || !step.T_before_keyframe) {
        out.push_back({time, to_mrpt(by_next)});
        continue;
      }
      const Eigen::Isometry3d by_last = to_isometry(keyframes[*before].pose) *
                                        *step.T_before_keyframe * entry.scan.T_keyframe_robot;
      const double last = keyframes[*before].time;
      const double part = (time - last) / (keyframes[k].time - last);
      out.push_back({time, to_mrpt(by_last * part_of_motion(by_last.inverse() * by_next, part))});
    }
    out.push_back(keyframes[k]);
    before = k;
  }
  return out;
}

}  // namespace hybrid
