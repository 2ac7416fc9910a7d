// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, the hybrid mapping authors

#include "mrpt_plugins/job/detail/scan_outputs.h"

#include <fmt/format.h>

#include <cmath>
#include <iterator>
#include <memory>
#include <utility>

#include "libhybrid/geometry/isometry.h"
#include "mrpt_plugins/bridge/pose_conversions.h"
#include "mrpt_plugins/bridge/poses.h"
#include "mrpt_plugins/job/detail/cloud_outputs.h"
#include "mrpt_plugins/map_file/stored_views.h"
#include "mrpt_plugins/mapping/scan_follower.h"
#include "mrpt_plugins/output/closure_csv.h"

namespace hybrid {
namespace {

const double kLevel = std::cos(5 * M_PI / 180);  // of the vertical axis of a sensor

/// A motion with its part in the plane replaced; height and tilt stay.
Eigen::Isometry3d moved_in_plane(const Eigen::Isometry3d& motion, const SE2& planar) {
  const double turn = planar.angle() - std::atan2(motion(1, 0), motion(0, 0));
  Eigen::Isometry3d out = Eigen::Isometry3d::Identity();
  out.linear() =
      Eigen::AngleAxisd(turn, Eigen::Vector3d::UnitZ()).toRotationMatrix() * motion.linear();
  out.translation() << planar.x(), planar.y(), motion.translation().z();
  return out;
}

/// A pose between keyframes by odometry, and where matches of scans place it.
struct Anchor {
  double time;
  Eigen::Isometry3d by_odometry, by_scans;  // seen from the keyframe
};

/// Moves poses by odometry along with the anchors before and after them, of which the last is the
/// keyframe.
void move_along(const std::vector<Anchor>& anchors, std::vector<PoseBetween>& poses) {
  const auto by = [](const Anchor& anchor, const Eigen::Isometry3d& T) {
    return anchor.by_scans * anchor.by_odometry.inverse() * T;
  };
  auto next = anchors.begin();
  for (PoseBetween& pose : poses) {
    while (next + 1 != anchors.end() && next->time <= pose.time) ++next;
    const Eigen::Isometry3d by_next = by(*next, pose.T_pose_robot);
    if (next == anchors.begin() || next->time <= pose.time) {
      pose.T_pose_robot = by_next;
      continue;
    }
    const Anchor& last = *(next - 1);
    const double part = (pose.time - last.time) / (next->time - last.time);
    pose.T_pose_robot = blend(by(last, pose.T_pose_robot), by_next, part);
  }
}

/// A keyframe whose scans are where matches place them, not odometry; `last`: time of the one
/// before.
Keyframe placed_by_scans(Keyframe keyframe, const ScanMotion& motion, std::optional<double> last) {
  std::vector<Anchor> anchors;
  if (motion.T_before_keyframe) {
    const bool has_odometry = keyframe.odometry.has_value();
    if (!has_odometry) keyframe.odometry.emplace();
    const Eigen::Isometry3d by_odometry = to_isometry(keyframe.odometry->mean);
    const Eigen::Isometry3d by_scans = moved_in_plane(by_odometry, *motion.T_before_keyframe);
    keyframe.odometry->mean = to_mrpt(by_scans);
    if (has_odometry && last) anchors.push_back({*last, by_odometry.inverse(), by_scans.inverse()});
  }
  for (std::size_t i = 0; i < motion.T_keyframe_robot.size(); ++i) {
    LaserScan& scan = keyframe.scans[i];
    Eigen::Isometry3d& T = scan.T_keyframe_robot;
    if (T.matrix().isIdentity(0)) continue;
    const Eigen::Isometry3d by_odometry = T;
    T = moved_in_plane(T, motion.T_keyframe_robot[i]);
    anchors.push_back({scan.time, by_odometry, T});
  }
  const Eigen::Isometry3d here = Eigen::Isometry3d::Identity();
  anchors.push_back({keyframe.time, here, here});
  move_along(anchors, keyframe.between);
  return keyframe;
}

std::string closures_csv(const std::vector<MeasuredClosure<SE2>>& closures) {
  std::string text = fmt::format("i,j,{},inliers,modes,x,y,yaw\n", kDecisionColumns);
  for (const MeasuredClosure<SE2>& c : closures) {
    fmt::format_to(std::back_inserter(text), "{},{},{},{},{},{},{},{}\n", c.from, c.to,
                   decision_cells(c.decision), c.inliers, c.modes, c.T_from_to.x(), c.T_from_to.y(),
                   c.T_from_to.angle());
  }
  return text;
}

}  // namespace

ScanOutputs::ScanOutputs(bool keeps_scans, bool is_3d,
                         std::vector<std::shared_ptr<MappingPlugin>> plugins)
    : paths_(keeps_scans, is_3d), plugins_(std::move(plugins)) {
  if (keeps_scans) archive_.emplace();
}

void ScanOutputs::added(const StepRecord& step, const Keyframe& keyframe) {
  if (!archive_) {
    paths_.add(keyframe);
    return;
  }
  const auto number = static_cast<std::size_t>(step.keyframe);
  for (const auto& plugin : plugins_) {
    const auto* follower = dynamic_cast<const ScanFollower*>(plugin.get());
    const std::optional<ScanMotion> motion =
        follower != nullptr ? follower->scan_motion() : std::nullopt;
    if (!motion) continue;
    const auto last = paths_.last_of().find(keyframe.robot);
    const Keyframe placed = placed_by_scans(
        keyframe, *motion,
        last == paths_.last_of().end() ? std::nullopt : std::optional(last->second.time));
    archive_->add(number, placed);
    paths_.add(placed, true);
    return;
  }
  archive_->add(number, keyframe);
  paths_.add(keyframe);
}

void ScanOutputs::finish(const LogMerge& source, MapResult& result) {
  for (const auto& [robot, last] : paths_.last_of()) paths_.end(robot, source.rest(robot));
  result.curves = paths_.curves(result.trajectory);
  result.reckoned_curves = paths_.reckoned_curves(result.dead_reckoning);
  for (const auto& plugin : plugins_) {
    const auto* follower = dynamic_cast<const ScanFollower*>(plugin.get());
    if (follower == nullptr) continue;
    for (const MeasuredClosure<SE2>& closure : follower->scan_closures()) {
      closures_.push_back(closure);
      result.scan_closures.push_back(closure);
    }
  }
  if (archive_) drawn_ = drawn_keyframes(*archive_, result.trajectory);
}

void ScanOutputs::draw(MapResult& result, const MapRecord& known) const {
  add_clouds(plugins_, known, result);
  if (!archive_) return;
  GridMap grid = draw_grid(stored_views(known), drawn_, result.trajectory);
  if (!grid.empty()) result.grid = std::make_shared<const GridMap>(std::move(grid));
}

std::vector<PlacedScan> ScanOutputs::placed(const Mapper& mapper,
                                            const Trajectory& keyframes) const {
  std::vector<PlacedScan> out;
  if (!archive_) return out;
  for (const KeyframeScans& at : drawn_keyframes(*archive_, keyframes)) {
    for (const LaserScan* scan : at.scans) {
      const Eigen::Isometry3d T = to_isometry(keyframes[at.keyframe].pose) * scan->T_robot_sensor;
      const double up = T.linear()(2, 2);
      if (std::abs(up) < kLevel) continue;
      out.push_back(
          {scan->time, static_cast<int>(mapper.robot_of(at.keyframe)), to_se2(T), up < 0, scan});
    }
  }
  return out;
}

std::vector<std::string> ScanOutputs::write(const OutputDirectory& out, const MapResult& result,
                                            const Mapper& mapper) const {
  std::vector<std::string> warnings;
  write_clouds(out, plugins_, result, mapper);
  if (!closures_.empty()) out.write("loops.csv", closures_csv(closures_));
  if (!archive_ || !result.grid) return warnings;
  out.write("map.pgm", grid_pgm(*result.grid));
  out.write("map.yaml", grid_yaml(*result.grid, "map.pgm"));
  write_simple_map(out, "map.simplemap", drawn_, result.trajectory, mapper.pose_covariances());
  if (archive_->given_up() > 0) {
    warnings.push_back(
        fmt::format("the log holds more scans than fit into {} MiB: {} of them are in the "
                    "trajectory and not in map.pgm, map.png and map.simplemap",
                    ScanArchive::kBudget >> 20, archive_->given_up()));
  }
  return warnings;
}

}  // namespace hybrid
