// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, the hybrid mapping authors

#include "mrpt_plugins/import/detail/table_odometry.h"

#include <fmt/format.h>
#include <mrpt/math/wrap2pi.h>

#include <algorithm>
#include <cmath>

#include "mrpt_plugins/evaluation/ground_truth.h"
#include "mrpt_plugins/import/detail/log_time.h"

namespace hybrid {
namespace {

using mrpt::poses::CPose3D;

/// Whether the first row has eight numbers, as a TUM trajectory.
bool is_tum(const std::string& path) {
  const auto row = TextReader(path).next();
  if (row->size() != 8) return false;
  for (std::size_t i = 0; i < row->size(); ++i) {
    if (!starts_like_a_number((*row)[i])) return false;
  }
  return true;
}

/// Whether all poses have the same z and no pitch or roll, within 1e-6.
bool are_planar(const std::vector<TimedPose>& poses) {
  constexpr double kDigits = 1e-6;
  return std::all_of(poses.begin(), poses.end(), [&](const TimedPose& p) {
    return std::abs(p.pose.z() - poses.front().pose.z()) < kDigits &&
           std::abs(p.pose.pitch()) < kDigits && std::abs(p.pose.roll()) < kDigits;
  });
}

/// All poses of a table whose rotations are quaternions.
std::vector<TimedPose> read_quaternions(NamedTable& table) {
  table.require({"time", "x", "y", "qx", "qy", "qz", "qw"});
  std::vector<TimedPose> poses;
  while (table.next()) {
    const Eigen::Vector3d position(table.number("x"), table.number("y"),
                                   table.has("z") ? table.number("z") : 0);
    if (!poses.empty() && table.time() < poses.back().time) {
      table.fail("time", "time is before the one above");
    }
    poses.push_back({table.time(), pose_in(table.row(), position,
                                           {table.column("qx"), table.column("qy"),
                                            table.column("qz"), table.column("qw")})});
  }
  return poses;
}

}  // namespace

OdometryIncrement wandering_motion(const CPose3D& from, const CPose3D& to, bool is_3d,
                                   double walk_translation, double walk_rotation) {
  constexpr double kLeast = 1e-6;
  const CPose3D mean = to - from;
  const double way = mean.norm();
  const double vt = kLeast + walk_translation * walk_translation * way;
  const double vr = kLeast + walk_rotation * walk_rotation * way;
  if (!is_3d) {
    return planar_motion(mean.x(), mean.y(), mean.yaw(), Eigen::Vector3d(vt, vt, vr).asDiagonal());
  }
  Eigen::Matrix<double, 6, 1> variances;
  variances << vt, vt, vt, vr, vr, vr;
  return {mean, variances.asDiagonal(), false};
}

CPose3D pose_between(const TimedPose& before, const TimedPose& after, double time) {
  const double f = (time - before.time) / (after.time - before.time);
  const CPose3D step = after.pose - before.pose;
  const auto part = [f](double angle) { return f * mrpt::math::wrapToPi(angle); };
  return before.pose + CPose3D(f * step.x(), f * step.y(), f * step.z(), part(step.yaw()),
                               part(step.pitch()), part(step.roll()));
}

TableOdometry::TableOdometry(const std::string& path) : path_(path) {
  if (is_tum(path)) {
    poses_ = read_tum(path);
    for (TimedPose& p : poses_) p.time = log_time(p.time);
    is_3d_ = !are_planar(poses_);
  } else {
    table_.emplace(path,
                   std::vector<std::string>{"time", "x", "y", "z", "yaw", "pitch", "roll", "qx",
                                            "qy", "qz", "qw"},
                   kColumnAliases);
    table_->require({"time", "x", "y"});
    if (table_->has("qw")) {
      poses_ = read_quaternions(*table_);
      is_3d_ = !are_planar(poses_);
      table_.reset();
    } else {
      table_->require({"yaw"});
      is_3d_ = table_->has("z");
      if (is_3d_) table_->require({"pitch", "roll"});
    }
  }
  advance();
  if (after_) start_ = after_->time;
  advance();
}

void TableOdometry::finish(LogWriter& log) {
  while (after_) pass();
  if (seems_real_part_first(poses_)) log.note(about_real_part_first(path_));
  if (gaps_ > 0) log.drop(OdometryGap::kMissing, gaps_);
  if (repeated_ > 0) {
    log.note(fmt::format("{}: {} rows have the time of the row above", path_, repeated_));
  }
}

std::optional<CPose3D> TableOdometry::at(double time) {
  while (after_ && after_->time < time) pass();
  const bool is_between = before_ && time > before_->time && after_ && time < after_->time;
  if (is_between && (is_new_ || has_gap_)) return std::nullopt;
  if (!before_ || time < before_->time) return std::nullopt;
  frame_ = is_new_ && time == before_->time ? resets_ - 1 : resets_;
  if (time == before_->time) return before_->pose;
  if (!after_) return std::nullopt;
  return pose_between(*before_, *after_, time);
}

void TableOdometry::pass() {
  if (watcher_) watcher_(*after_);
  advance();
}

void TableOdometry::advance() {
  if (after_ || !before_) before_ = after_;
  after_.reset();
  if (table_) {
    read_row();
  } else if (read_ < poses_.size()) {
    after_ = poses_[read_++];
    note_place(after_->pose);
  }
  if (before_ && after_ && after_->time == before_->time) ++repeated_;
  if (after_) end_ = after_->time;
  if (before_ && after_ && !is_new_) way_ += (after_->pose - before_->pose).norm();
  if (is_new_) gap_.start_anew();
  has_gap_ = after_ && gap_.before(after_->time, to_isometry(after_->pose));
  if (has_gap_) ++gaps_;
}

/// Notes whether odometry starts anew at its next pose.
void TableOdometry::note_place(const CPose3D& pose) {
  is_new_ = reset_.at({pose.x(), pose.y(), pose.z()});
  if (is_new_) ++resets_;
}

void TableOdometry::read_row() {
  is_new_ = false;
  if (!table_->next()) return;
  const double time = table_->time();
  if (before_ && time < before_->time) table_->fail("time", "time is before the one above");
  const double yaw = table_->number("yaw");
  note_place({table_->number("x"), table_->number("y"), is_3d_ ? table_->number("z") : 0, 0, 0, 0});
  if (yaw_ && !is_new_ && std::abs(yaw - *yaw_) > 2 * M_PI) {
    table_->fail("yaw", fmt::format("yaw turns by {:.4g} in one row, over a full turn: angles are "
                                    "in radians",
                                    yaw - *yaw_));
  }
  yaw_ = yaw;
  const auto space = [&](const char* name, bool is_angle) {
    if (!is_3d_) return 0.0;
    return is_angle ? table_->angle(name) : table_->number(name);
  };
  after_ = {time, CPose3D(table_->number("x"), table_->number("y"), space("z", false), yaw,
                          space("pitch", true), space("roll", true))};
}

}  // namespace hybrid
