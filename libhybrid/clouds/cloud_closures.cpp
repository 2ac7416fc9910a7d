// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, the hybrid mapping authors

#include "libhybrid/clouds/cloud_closures.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <utility>

#include "libhybrid/scans/correlative_search.h"

namespace hybrid {
namespace {

/// Targets kept in memory; others are made again when needed.
constexpr std::size_t kMostTargets = 20;
/// Standard deviations that a window covers: what holds 99.7 % of a Student t of 4 degrees of
/// freedom, since some matches are wrong. Its least size is so many spacings, and this turn [rad].
constexpr double kCovered = 6.6;
constexpr double kLeastWindow = 2;
constexpr double kLeastTurn = 0.08;
/// Surfaces whose normals are steeper than this are walls, and fewer of them tell no pose.
constexpr double kWall = 0.5;
constexpr std::size_t kFewWalls = 50;
constexpr std::size_t kWallPoints = 200;  // that a search uses
/// Errors of height are tried in steps of so many spacings, at most so many up and down.
constexpr double kHeightStep = 1.5;
constexpr int kMostHeights = 3;
constexpr std::size_t kHeightPoints = 400;  // that choose one of these
/// Modes closer together than this are one [spacings], [rad].
constexpr double kOneMode = 3;
constexpr double kOneModeTurn = 0.05;

double yaw_of(const Eigen::Matrix3d& R) {
  return std::atan2(R(1, 0), R(0, 0));
}
Eigen::Matrix3d turn_about_z(double angle) {
  return Eigen::AngleAxisd(angle, Eigen::Vector3d::UnitZ()).toRotationMatrix();
}
SE3 turned(const Eigen::Matrix3d& R) {
  return {Eigen::Vector3d::Zero(), Eigen::Quaterniond(R)};
}

/// The rotation of an estimated pose without its heading: it makes axes of the robot level.
Eigen::Matrix3d level_of(const SE3& pose) {
  const Eigen::Matrix3d R = pose.rotation().matrix();
  return turn_about_z(-yaw_of(R)) * R;
}

/// Where points of walls are, seen from above, in a frame turned by `R`.
std::vector<Eigen::Vector2d> walls(const std::vector<CloudPoint>& points,
                                   const Eigen::Matrix3d& R) {
  std::vector<Eigen::Vector2d> out;
  for (const CloudPoint& point : points) {
    if (std::abs(R.row(2) * point.normal.cast<double>()) > kWall) continue;
    out.push_back((R * point.position.cast<double>()).head<2>());
  }
  return out;
}

std::vector<Eigen::Vector2d> thinned(const std::vector<Eigen::Vector2d>& points, std::size_t most) {
  if (points.size() <= most) return points;
  std::vector<Eigen::Vector2d> out;
  for (std::size_t i = 0; i < most; ++i) out.push_back(points[i * points.size() / most]);
  return out;
}

}  // namespace

/// What is seen at the end of the path, in the frame of the newest cloud.
struct CloudClosureSearch::Query {
  std::size_t cloud = 0;
  double spacing = 0, reach = 0;
  std::vector<CloudPoint> points, coarse;
  double shared = 1;               // number of searches that share them
  Matrix6 walk = Matrix6::Zero();  // covariance of the motion along it
};

/// Complete local maps that were left behind, nearest first.
std::vector<std::size_t> CloudClosureSearch::candidates(const CloudTracker& tracker,
                                                        const Poses& poses, double reach) const {
  const std::vector<LocalCloud>& maps = tracker.local_maps();
  const Eigen::Vector3d here = poses(tracker.clouds() - 1).translation();
  std::vector<std::pair<double, std::size_t>> near;
  for (std::size_t m = 0; m + 1 < maps.size(); ++m) {
    const LocalCloud& map = maps[m];
    if (map.anchor + map.poses.size() > maps.back().anchor || map.points.empty()) continue;
    const SE3 anchor = poses(map.anchor);
    double nearest = std::numeric_limits<double>::infinity();
    for (const SE3& pose : map.poses) {
      nearest = std::min(nearest, (anchor * pose.translation() - here).norm());
    }
    if (nearest < (options_.view + options_.max_reach) * reach) near.emplace_back(nearest, m);
  }
  std::stable_sort(near.begin(), near.end());
  std::vector<std::size_t> out;
  for (const auto& [distance, m] : near) {
    const bool overlaps = std::any_of(out.begin(), out.end(), [m = m](std::size_t other) {
      return other + 1 == m || m + 1 == other;
    });
    if (!overlaps && static_cast<int>(out.size()) < options_.most_maps) out.push_back(m);
  }
  return out;
}

/// Made when first needed, and kept as long as it is among those used last.
CloudClosureSearch::Target& CloudClosureSearch::target(const LocalCloud& map, std::size_t number,
                                                       double spacing,
                                                       const Eigen::Matrix3d& level) {
  auto found = targets_.find(number);
  if (found == targets_.end()) {
    Target made{CloudSurfaces(spacing), {}, 0};
    made.surfaces.add(map.points);
    made.walls = LikelihoodField(walls(made.surfaces.points(), level), spacing, 1.2 * spacing);
    found = targets_.emplace(number, std::move(made)).first;
  }
  found->second.used = ++searches_;
  if (targets_.size() > kMostTargets) {
    targets_.erase(std::min_element(
        targets_.begin(), targets_.end(),
        [](const auto& a, const auto& b) { return a.second.used < b.second.used; }));
  }
  return found->second;
}

/// Poses from which surfaces may be aligned, in the frame of the target.
std::vector<SE3> CloudClosureSearch::starts(const Query& query, const Target& target,
                                            const Eigen::Matrix3d& level,
                                            const UncertainMotion3& predicted) const {
  std::vector<SE3> out{predicted.motion};
  const Eigen::Matrix3d R = level * predicted.motion.rotation().matrix();
  const Eigen::Vector3d centre = level * predicted.motion.translation();
  const Eigen::Matrix3d own_level = turn_about_z(-yaw_of(R)) * R;
  const std::vector<Eigen::Vector2d> seen = walls(query.points, own_level);
  if (seen.size() < kFewWalls || target.walls.empty()) return out;
  const Eigen::Matrix3d C = R * predicted.covariance.topLeftCorner<3, 3>() * R.transpose();
  const Eigen::Matrix3d Q = R * predicted.covariance.bottomRightCorner<3, 3>() * R.transpose();
  const double least = kLeastWindow * query.spacing, most = options_.max_reach * query.reach;
  SearchWindow window;
  window.centre = SE2(centre.x(), centre.y(), yaw_of(R));
  window.reach.x() = std::clamp(kCovered * std::sqrt(C(0, 0)), least, most);
  window.reach.y() = std::clamp(kCovered * std::sqrt(C(1, 1)), least, most);
  window.turn = std::clamp(kCovered * std::sqrt(Q(2, 2)), kLeastTurn, options_.max_turn);
  SearchOptions options;
  options.same_translation = 2 * query.spacing;
  for (const SearchMode& mode :
       search_poses(thinned(seen, kWallPoints), target.walls, window, options)) {
    const Eigen::Vector3d at(mode.pose.x(), mode.pose.y(), centre.z());
    const Eigen::Matrix3d turn = turn_about_z(mode.pose.angle()) * own_level;
    out.push_back(turned(level.transpose()) * SE3(at, Eigen::Quaterniond(turn)));
  }
  // Nothing so far tells the height.
  const double step = kHeightStep * query.spacing;
  const int heights = std::min(kMostHeights, static_cast<int>(3 * std::sqrt(C(2, 2)) / step));
  CloudAlignmentOptions quick;
  quick.with_information = false;
  const Eigen::Vector3d up = level.transpose() * Eigen::Vector3d::UnitZ();
  for (SE3& start : out) {
    SE3 best = start;
    double most_inliers = -1;
    for (int i = 0; i <= 2 * heights; ++i) {
      const double rise = step * (i % 2 == 0 ? i / 2 : -(i + 1) / 2);
      const SE3 moved(start.translation() + rise * up, start.rotation());
      const CloudAlignment found = align(query.coarse, target.surfaces, moved, quick);
      if (found.inliers <= most_inliers) continue;
      most_inliers = found.inliers;
      best = found.pose;
    }
    start = best;
  }
  return out;
}

/// Adds all poses at which the query matches a local map.
void CloudClosureSearch::look(const Query& query, const LocalCloud& map, std::size_t number,
                              const Poses& poses, const Relation& relation,
                              std::vector<CloudClosure>& closures) {
  const Eigen::Matrix3d level = level_of(poses(map.anchor));
  const Target& target = this->target(map, number, query.spacing, level);
  std::vector<CloudAlignment> modes;
  for (const SE3& start : starts(query, target, level, relation(map.anchor, query.cloud))) {
    const CloudAlignment found = align(query.points, target.surfaces, start);
    if (found.inliers < options_.min_inliers) continue;
    const bool is_known = std::any_of(modes.begin(), modes.end(), [&](const CloudAlignment& m) {
      const SE3 off = m.pose.between(found.pose);
      return off.translation().norm() < kOneMode * query.spacing &&
             off.rotation().log().norm() < kOneModeTurn;
    });
    if (!is_known) modes.push_back(found);
  }
  std::stable_sort(
      modes.begin(), modes.end(),
      [](const CloudAlignment& a, const CloudAlignment& b) { return a.support > b.support; });
  const std::size_t first = closures.size();
  for (const CloudAlignment& mode : modes) {
    // What lies between the anchor and the nearest cloud is not known as well as the match is.
    const auto nearest =
        std::min_element(map.poses.begin(), map.poses.end(), [&](const SE3& a, const SE3& b) {
          return (a.translation() - mode.pose.translation()).norm() <
                 (b.translation() - mode.pose.translation()).norm();
        });
    CloudClosure out;
    out.from = map.anchor + static_cast<std::size_t>(nearest - map.poses.begin());
    out.to = query.cloud;
    // The places of a stretch walk at random relative to its end, and so does their mean, by a
    // third of that; the same holds for the map. Searches that share points tell a share each.
    out.pose = {nearest->between(mode.pose),
                query.shared * (alignment_covariance(mode) + 2.0 / 3.0 * query.walk)};
    out.inliers = mode.inliers;
    out.modes = static_cast<int>(modes.size());
    out.first_mode = first;
    closures.push_back(out);
  }
}

std::vector<CloudClosure> CloudClosureSearch::search(const CloudTracker& tracker,
                                                     const Poses& poses, const Relation& relation) {
  std::vector<CloudClosure> closures;
  const double reach = tracker.reach();
  if (tracker.surfaces() == nullptr || options_.most_maps == 0) return closures;
  const LocalCloud& present = tracker.local_maps().back();
  const double way = present.travelled.back();
  if (way < next_) return closures;
  next_ = way + options_.every * reach;
  const std::vector<std::size_t> near = candidates(tracker, poses, reach);
  if (near.empty()) return closures;
  Query query;
  query.cloud = tracker.clouds() - 1;
  query.spacing = tracker.surfaces()->spacing();
  query.reach = reach;
  query.points = chosen(transformed(present.poses.back().inverse(), tracker.surfaces()->points()),
                        options_.most_points);
  query.coarse = chosen(query.points, kHeightPoints);
  const double seen = way - present.travelled.front();
  query.shared = std::max(1.0, seen / (options_.every * reach));
  if (present.anchor < query.cloud) {
    query.walk = relation(present.anchor, query.cloud).covariance;
  }
  for (const std::size_t m : near) {
    look(query, tracker.local_maps()[m], m, poses, relation, closures);
  }
  return closures;
}

}  // namespace hybrid
