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

/// A keyframe whose scans are where matches place them, not odometry.
Keyframe placed_by_scans(Keyframe keyframe, const ScanMotion& motion) {
  if (motion.T_before_keyframe) {
    if (!keyframe.odometry) keyframe.odometry.emplace();
    keyframe.odometry->mean =
        to_mrpt(moved_in_plane(to_isometry(keyframe.odometry->mean), *motion.T_before_keyframe));
  }
  for (std::size_t i = 0; i < motion.T_keyframe_robot.size(); ++i) {
    Eigen::Isometry3d& T = keyframe.scans[i].T_keyframe_robot;
    if (!T.matrix().isIdentity(0)) T = moved_in_plane(T, motion.T_keyframe_robot[i]);
  }
  return keyframe;
}

std::string closures_csv(const std::vector<MeasuredClosure>& closures) {
  std::string text = fmt::format("i,j,{},inliers,modes,x,y,yaw\n", kDecisionColumns);
  for (const MeasuredClosure& c : closures) {
    fmt::format_to(std::back_inserter(text), "{},{},{},{},{},{},{},{}\n", c.from, c.to,
                   decision_cells(c.decision), c.inliers, c.modes, c.T_from_to.x(), c.T_from_to.y(),
                   c.T_from_to.angle());
  }
  return text;
}

}  // namespace

ScanOutputs::ScanOutputs(bool keeps_scans, std::vector<std::shared_ptr<MappingPlugin>> plugins)
    : plugins_(std::move(plugins)) {
  if (keeps_scans) archive_.emplace();
}

void ScanOutputs::added(const StepRecord& step, const Keyframe& keyframe) {
  if (!archive_) return;
  const auto number = static_cast<std::size_t>(step.keyframe);
  for (const auto& plugin : plugins_) {
    const auto* follower = dynamic_cast<const ScanFollower*>(plugin.get());
    const std::optional<ScanMotion> motion =
        follower != nullptr ? follower->scan_motion() : std::nullopt;
    if (!motion) continue;
    archive_->add(number, placed_by_scans(keyframe, *motion));
    return;
  }
  archive_->add(number, keyframe);
}

void ScanOutputs::finish(MapResult& result) {
  for (const auto& plugin : plugins_) {
    const auto* follower = dynamic_cast<const ScanFollower*>(plugin.get());
    if (follower == nullptr) continue;
    for (const MeasuredClosure& closure : follower->scan_closures()) {
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

Trajectory ScanOutputs::path(const RobotPart& part, const MapResult& whole,
                             std::size_t robot) const {
  return archive_ ? archive_->path(whole.trajectory, robot) : part.result.trajectory;
}

}  // namespace hybrid
