// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, the hybrid mapping authors

#include "libhybrid/clouds/cloud_match.h"

#include <algorithm>
#include <cmath>

#include "libhybrid/clouds/detail/plan_view.h"
#include "libhybrid/core/evenly_chosen.h"
#include "libhybrid/scans/correlative_search.h"

namespace hybrid {
namespace {

/// Standard deviations that a window covers: what holds 99.7 % of a Student t of 4 degrees of
/// freedom, since some matches are wrong. Its least size is so many spacings, and this turn [rad].
constexpr double kCovered = 6.6;
constexpr double kLeastWindow = 2;
constexpr double kLeastTurn = 0.08;
/// Modes closer together than this are one [spacings], [rad].
constexpr double kOneMode = 3;
constexpr double kOneModeTurn = 0.05;
constexpr std::size_t kFewWalls = 50;     // fewer points of walls tell no pose
constexpr std::size_t kWallPoints = 200;  // that a search uses
/// Errors of height are tried in steps of so many spacings, at most so many up and down.
constexpr double kHeightStep = 1.5;
constexpr int kMostHeights = 3;
constexpr std::size_t kHeightPoints = 400;  // that choose one of these

/// The window of poses in the plane that a prediction in a level frame allows.
SearchWindow planar_window(const UncertainMotion3& predicted, const Eigen::Matrix3d& level,
                           double spacing, const CloudMatchOptions& options) {
  const Eigen::Matrix3d R = level * predicted.motion.rotation().matrix();
  const Eigen::Vector3d centre = level * predicted.motion.translation();
  const Eigen::Matrix3d C = R * predicted.covariance.topLeftCorner<3, 3>() * R.transpose();
  const Eigen::Matrix3d Q = R * predicted.covariance.bottomRightCorner<3, 3>() * R.transpose();
  const double least = kLeastWindow * spacing;
  SearchWindow window;
  window.centre = SE2(centre.x(), centre.y(), yaw_of(R));
  window.reach.x() = std::clamp(kCovered * std::sqrt(C(0, 0)), least, options.max_reach);
  window.reach.y() = std::clamp(kCovered * std::sqrt(C(1, 1)), least, options.max_reach);
  window.turn = std::clamp(kCovered * std::sqrt(Q(2, 2)), kLeastTurn, options.max_turn);
  return window;
}

/// Poses from which surfaces may be aligned, in the frame of the target.
std::vector<SE3> starts(const std::vector<CloudPoint>& points, const CloudTarget& target,
                        const UncertainMotion3& predicted, const CloudMatchOptions& options) {
  std::vector<SE3> out{predicted.motion};
  const double spacing = target.surfaces.spacing();
  const Eigen::Matrix3d R = target.level * predicted.motion.rotation().matrix();
  const Eigen::Matrix3d own_level = turn_about_z(-yaw_of(R)) * R;
  const std::vector<Eigen::Vector2d> seen = positions_of(walls_of(points, own_level));
  if (seen.size() < kFewWalls || target.walls.empty()) return out;
  SearchOptions search;
  search.same_translation = 2 * spacing;
  const double height = (target.level * predicted.motion.translation()).z();
  const SearchWindow window = planar_window(predicted, target.level, spacing, options);
  const SE3 T_target_level(Eigen::Vector3d::Zero(), Eigen::Quaterniond(target.level.transpose()));
  for (const SearchMode& mode :
       search_poses(evenly_chosen(seen, kWallPoints), target.walls, window, search)) {
    const Eigen::Vector3d at(mode.pose.x(), mode.pose.y(), height);
    const Eigen::Matrix3d turn = turn_about_z(mode.pose.angle()) * own_level;
    out.push_back(T_target_level * SE3(at, Eigen::Quaterniond(turn)));
  }
  // Nothing so far tells the height.
  const Eigen::RowVector3d up = target.level.row(2) * predicted.motion.rotation().matrix();
  const double sigma = std::sqrt(up * predicted.covariance.topLeftCorner<3, 3>() * up.transpose());
  const double step = kHeightStep * spacing;
  const int steps = std::min(kMostHeights, static_cast<int>(3 * sigma / step));
  const std::vector<CloudPoint> coarse = evenly_chosen(points, kHeightPoints);
  for (SE3& start : out) {
    start = at_best_height(coarse, target.surfaces, start, step * target.level.row(2).transpose(),
                           steps);
  }
  return out;
}

}  // namespace

CloudTarget make_cloud_target(const std::vector<CloudPoint>& points, double spacing,
                              const SE3& T_map_frame) {
  CloudTarget out{CloudSurfaces(spacing), {}, level_of(T_map_frame)};
  out.surfaces.add(points);
  const auto walls = positions_of(walls_of(out.surfaces.points(), out.level));
  out.walls = LikelihoodField(walls, spacing, 1.2 * spacing);
  return out;
}

bool are_one_pose(const SE3& a, const SE3& b, double spacing) {
  const SE3 off = a.between(b);
  return off.translation().norm() < kOneMode * spacing &&
         off.rotation().log().norm() < kOneModeTurn;
}

std::vector<CloudAlignment> match(const std::vector<CloudPoint>& points, const CloudTarget& target,
                                  const UncertainMotion3& predicted,
                                  const CloudMatchOptions& options) {
  const std::vector<CloudPoint> used = evenly_chosen(points, options.most_points);
  std::vector<CloudAlignment> modes;
  for (const SE3& start : starts(used, target, predicted, options)) {
    const CloudAlignment found = align(used, target.surfaces, start);
    if (found.inliers < options.min_inliers) continue;
    const bool is_known = std::any_of(modes.begin(), modes.end(), [&](const CloudAlignment& m) {
      return are_one_pose(m.pose, found.pose, target.surfaces.spacing());
    });
    if (!is_known) modes.push_back(found);
  }
  std::stable_sort(
      modes.begin(), modes.end(),
      [](const CloudAlignment& a, const CloudAlignment& b) { return a.support > b.support; });
  return modes;
}

}  // namespace hybrid
