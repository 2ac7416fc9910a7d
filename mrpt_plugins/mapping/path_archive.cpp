// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, the hybrid mapping authors

#include "mrpt_plugins/mapping/path_archive.h"

#include <algorithm>
#include <limits>
#include <memory>
#include <utility>

#include "mrpt_plugins/bridge/pose_conversions.h"

namespace hybrid {
namespace {

/// What a person sees of a path in a map of a room [m].
constexpr double kDrawn = 0.01;

Eigen::Matrix<double, 3, 4> rows_of(const Eigen::Isometry3d& T) {
  return T.matrix().topRows<3>();
}

Eigen::Isometry3d isometry_of(const Eigen::Matrix<double, 3, 4>& rows) {
  Eigen::Isometry3d out = Eigen::Isometry3d::Identity();
  out.matrix().topRows<3>() = rows;
  return out;
}

double distance_to_line(const Eigen::Vector3d& point, const Eigen::Vector3d& from,
                        const Eigen::Vector3d& to) {
  const Eigen::Vector3d line = to - from;
  const double square = line.squaredNorm();
  const double along = square > 0 ? std::clamp((point - from).dot(line) / square, 0.0, 1.0) : 0;
  return (point - from - along * line).norm();
}

/// The points between the first and the last of a curve of at least two that must stay, so that all
/// are within a tolerance [m] of straight lines between those that do (Douglas and Peucker).
std::vector<Eigen::Vector3d> thinned(const std::vector<Eigen::Vector3d>& curve, double tolerance) {
  std::vector<bool> stays(curve.size(), false);
  std::vector<std::pair<std::size_t, std::size_t>> pieces{{0, curve.size() - 1}};
  while (!pieces.empty()) {
    const auto [from, to] = pieces.back();
    pieces.pop_back();
    std::size_t farthest = from;
    double most = tolerance;
    for (std::size_t i = from + 1; i < to; ++i) {
      const double distance = distance_to_line(curve[i], curve[from], curve[to]);
      if (distance <= most) continue;
      most = distance;
      farthest = i;
    }
    if (farthest == from) continue;
    stays[farthest] = true;
    pieces.emplace_back(from, farthest);
    pieces.emplace_back(farthest, to);
  }
  std::vector<Eigen::Vector3d> out;
  for (std::size_t i = 0; i < curve.size(); ++i) {
    if (stays[i]) out.push_back(curve[i]);
  }
  return out;
}

/// A piece of a path between points that stay, and where its drawn points go.
struct Piece {
  std::vector<Eigen::Vector3d> points;
  std::vector<Eigen::Vector3d>* drawn;
  bool ends = false;  // with it the path ends, whose last point is drawn
};

/// Fills in what is drawn; returns whether that is anything.
bool draw(const std::vector<Piece>& pieces, std::size_t most) {
  std::size_t count = 0;
  double tolerance = kDrawn;
  do {
    count = 0;
    for (const Piece& piece : pieces) {
      *piece.drawn = thinned(piece.points, tolerance);
      count += piece.drawn->size();
      if (piece.ends) piece.drawn->push_back(piece.points.back());
    }
    tolerance *= 2;
  } while (count > most);
  return std::any_of(pieces.begin(), pieces.end(),
                     [](const Piece& piece) { return !piece.drawn->empty(); });
}

}  // namespace

void PathArchive::add(const Keyframe& keyframe, bool is_matched) {
  Step step{keyframe.robot, is_matched, {}, nullptr};
  if (keeps_scans_) {
    for (const LaserScan& scan : keyframe.scans) {
      if (scan.T_keyframe_robot.matrix().isIdentity(0)) continue;  // of the keyframe itself
      step.entries.push_back({scan.time, rows_of(scan.T_keyframe_robot), true, false});
    }
  }
  if (keyframe.odometry && last_of_.count(keyframe.robot) != 0) {
    add_odometry(keyframe.time, keyframe.between, step.entries);
  }
  if (keyframe.odometry && !step.entries.empty()) {
    step.T_before_keyframe =
        std::make_unique<const Eigen::Isometry3d>(to_isometry(keyframe.odometry->mean));
  }
  last_of_[keyframe.robot] = {steps_.size(), keyframe.time};
  steps_.push_back(std::move(step));
  thin_out();
}

void PathArchive::end(std::size_t robot, const std::vector<PoseBetween>& rest) {
  if (last_of_.count(robot) == 0) return;
  Step step{robot, false, {}, nullptr};
  add_odometry(std::numeric_limits<double>::infinity(), rest, step.entries);
  rests_[robot] = std::move(step);
  thin_out();
}

/// Adds poses before an end to entries of scans, in order of time; of one time, the scan stays.
void PathArchive::add_odometry(double end, const std::vector<PoseBetween>& poses,
                               std::vector<Entry>& entries) {
  const std::vector<Entry> scans = std::exchange(entries, {});
  auto scan = scans.begin();
  for (const PoseBetween& pose : poses) {
    if (pose.time >= end) break;
    while (scan != scans.end() && scan->time <= pose.time) entries.push_back(*scan++);
    if (!entries.empty() && entries.back().time == pose.time) {
      entries.back().is_odometry = true;
      continue;
    }
    const Eigen::Isometry3d& T = pose.T_pose_robot;
    entries.push_back({pose.time, rows_of(is_3d_ ? T : to_isometry(to_se2(T))), false, true});
    ++count_;
  }
  entries.insert(entries.end(), scan, scans.end());
  entries.shrink_to_fit();
}

void PathArchive::thin_out() {
  while (count_ > most_) {
    bool keeps = true;
    for (Step& step : steps_) thin_out(step.entries, keeps);
    for (auto& [robot, rest] : rests_) thin_out(rest.entries, keeps);
  }
}

void PathArchive::thin_out(std::vector<Entry>& entries, bool& keeps) {
  const auto end = std::remove_if(entries.begin(), entries.end(), [&](const Entry& entry) {
    if (entry.is_scan) return false;
    keeps = !keeps;
    return keeps;
  });
  count_ -= static_cast<std::size_t>(entries.end() - end);
  entries.erase(end, entries.end());
  entries.shrink_to_fit();
}

bool PathArchive::counts(const Step& step, const Entry& entry, Kind kind) {
  if (kind == Kind::kAll) return true;
  return entry.is_odometry && !(kind == Kind::kReckoned && step.is_matched);
}

/// Adds the poses between a keyframe and the one before of its robot.
void PathArchive::add_poses(std::size_t k, std::optional<std::size_t> before,
                            const Trajectory& keyframes, Kind kind, Trajectory& out) const {
  const Step& step = steps_[k];
  const Eigen::Isometry3d T_map_keyframe = to_isometry(keyframes[k].pose);
  Eigen::Isometry3d T_map_reckoned;  // the keyframe by odometry from the one before
  if (before && step.T_before_keyframe) {
    T_map_reckoned = to_isometry(keyframes[*before].pose) * *step.T_before_keyframe;
  }
  for (const Entry& entry : step.entries) {
    const double time = entry.time;
    const bool is_between = time < keyframes[k].time && (out.empty() || time > out.back().time);
    if (!is_between || !counts(step, entry, kind)) continue;
    const Eigen::Isometry3d T_keyframe_robot = isometry_of(entry.T_keyframe_robot);
    const Eigen::Isometry3d by_next = T_map_keyframe * T_keyframe_robot;
    if (!before || !step.T_before_keyframe) {
      out.push_back({time, to_mrpt(by_next)});
      continue;
    }
    const double last = keyframes[*before].time;
    const double part = (time - last) / (keyframes[k].time - last);
    out.push_back({time, to_mrpt(blend(T_map_reckoned * T_keyframe_robot, by_next, part))});
  }
}

/// Adds the poses after the last keyframe of a robot.
void PathArchive::add_rest(std::size_t robot, const Trajectory& keyframes, Trajectory& out) const {
  const auto rest = rests_.find(robot);
  if (rest == rests_.end()) return;
  const Eigen::Isometry3d T_map_keyframe = to_isometry(keyframes[last_of_.at(robot).keyframe].pose);
  for (const Entry& entry : rest->second.entries) {
    if (entry.time <= out.back().time) continue;
    out.push_back({entry.time, to_mrpt(T_map_keyframe * isometry_of(entry.T_keyframe_robot))});
  }
}

Trajectory PathArchive::path(const Trajectory& keyframes, std::size_t robot, Kind kind) const {
  Trajectory out;
  out.reserve(steps_.size() + count_);
  std::optional<std::size_t> before;
  for (std::size_t k = 0; k < steps_.size(); ++k) {
    if (steps_[k].robot != robot) continue;
    add_poses(k, before, keyframes, kind, out);
    out.push_back(keyframes[k]);
    before = k;
  }
  if (before) add_rest(robot, keyframes, out);
  return out;
}

Trajectory PathArchive::path(const Trajectory& keyframes, std::size_t robot) const {
  return path(keyframes, robot, Kind::kAll);
}

Trajectory PathArchive::reckoned_path(const Trajectory& keyframes, std::size_t robot) const {
  return path(keyframes, robot, Kind::kReckoned);
}

PathCurves PathArchive::curves(const Trajectory& keyframes, Kind kind) const {
  PathCurves out;
  out.to.resize(steps_.size());
  std::vector<Piece> pieces;
  std::map<std::size_t, std::size_t> before;  // of each robot
  const auto add = [&](const Trajectory& poses, std::vector<Eigen::Vector3d>& drawn, bool ends) {
    Piece piece{{}, &drawn, ends};
    for (const TimedPose& pose : poses) piece.points.push_back(point_of(pose.pose));
    if (poses.size() > 1) pieces.push_back(std::move(piece));
  };
  for (std::size_t k = 0; k < steps_.size(); ++k) {
    const auto last = before.find(steps_[k].robot);
    if (last != before.end() && !steps_[k].entries.empty()) {
      Trajectory poses{keyframes[last->second]};
      add_poses(k, last->second, keyframes, kind, poses);
      poses.push_back(keyframes[k]);
      add(poses, out.to[k], false);
    }
    before[steps_[k].robot] = k;
  }
  if (!before.empty()) out.after.resize(before.rbegin()->first + 1);
  for (const auto& [robot, last] : before) {
    Trajectory poses{keyframes[last]};
    add_rest(robot, keyframes, poses);
    add(poses, out.after[robot], true);
  }
  return draw(pieces, kMostDrawn) ? out : PathCurves();
}

PathCurves PathArchive::curves(const Trajectory& keyframes) const {
  return curves(keyframes, Kind::kOdometry);
}

PathCurves PathArchive::reckoned_curves(const Trajectory& keyframes) const {
  return curves(keyframes, Kind::kReckoned);
}

}  // namespace hybrid
