// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, the hybrid mapping authors

#include "mrpt_plugins/map_file/stored_views.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include "libhybrid/geometry/isometry.h"
#include "libhybrid/geometry/se2.h"
#include "mrpt_plugins/bridge/pose_conversions.h"

namespace hybrid {
namespace {

constexpr double kStretch = 8.0;  // way along which a local map was seen [m]
constexpr double kApart = 1.0;    // between views of it [m]
constexpr int kRays = 720;        // of a view, all around
constexpr double kStep = 2 * M_PI / kRays;
constexpr double kSpacing = 0.1;  // of points on surfaces [m]
constexpr double kBesideRobot = 0.1;
constexpr double kSeenTo = 200.0;  // that a local map reaches [m]

/// What is seen of a local map from a place in its frame.
LaserScan view_of(const MapLocalMap& local, const SE2& T_local_robot) {
  LaserScan scan;
  scan.first_angle = -M_PI;
  scan.angle_step = kStep;
  scan.max_range = kSeenTo;
  scan.ranges.assign(kRays, std::numeric_limits<float>::quiet_NaN());
  const SE2 T_robot_local = T_local_robot.inverse();
  for (const MapSurface& surface : local.surfaces) {
    const Eigen::Vector2d p = T_robot_local * surface.position;
    const double range = p.norm();
    if (range < kBesideRobot) continue;
    const double middle = (std::atan2(p.y(), p.x()) + M_PI) / kStep;
    const int half = static_cast<int>(std::ceil(0.5 * kSpacing / range / kStep));
    for (int i = -half; i <= half; ++i) {
      const int ray = (static_cast<int>(std::lround(middle)) + i + kRays) % kRays;
      float& seen = scan.ranges[static_cast<std::size_t>(ray)];
      if (!(seen <= range)) seen = static_cast<float>(range);
    }
  }
  return scan;
}

/// The keyframe of a session that is the anchor of a local map.
std::size_t anchor_of(const SE2& T_map_local, const MapSession& session) {
  const auto distance = [&](const MapKeyframe& keyframe) {
    return T_map_local.between(to_se2(keyframe.T_map_robot)).log().norm();
  };
  const auto nearest =
      std::min_element(session.keyframes.begin(), session.keyframes.end(),
                       [&](const auto& a, const auto& b) { return distance(a) < distance(b); });
  return static_cast<std::size_t>(nearest - session.keyframes.begin());
}

/// From where a local map was seen, in its frame.
std::vector<SE2> places_of(const SE2& T_map_local, const MapSession& session) {
  std::vector<SE2> out{SE2()};
  if (session.keyframes.empty()) return out;
  const std::size_t anchor = anchor_of(T_map_local, session);
  const SE2 T_anchor_map = to_se2(session.keyframes[anchor].T_map_robot).inverse();
  SE2 last;
  double way = 0;
  for (std::size_t k = anchor + 1; k < session.keyframes.size() && way < kStretch; ++k) {
    if (session.keyframes[k].robot != session.keyframes[anchor].robot) continue;
    const SE2 here = T_anchor_map * to_se2(session.keyframes[k].T_map_robot);
    way += last.between(here).translation().norm();
    last = here;
    if (out.back().between(here).translation().norm() >= kApart) out.push_back(here);
  }
  return out;
}

}  // namespace

StoredViews stored_views(const MapRecord& map) {
  StoredViews out;
  for (const MapLocalMap& local : map.local_maps) {
    const SE2 T_map_local(local.pose.x(), local.pose.y(), local.pose.z());
    for (const MapSession& session : map.sessions) {
      if (session.id != local.session) continue;
      for (const SE2& place : places_of(T_map_local, session)) {
        const SE2 at = T_map_local * place;
        out.poses.push_back({0, mrpt::poses::CPose3D(at.x(), at.y(), 0, at.angle(), 0, 0)});
        out.scans.push_back(view_of(local, place));
      }
    }
  }
  return out;
}

GridMap draw_grid(const StoredViews& views, const std::vector<KeyframeScans>& scans,
                  const Trajectory& keyframes) {
  Trajectory poses = views.poses;
  poses.insert(poses.end(), keyframes.begin(), keyframes.end());
  std::vector<KeyframeScans> all;
  for (std::size_t i = 0; i < views.scans.size(); ++i) all.push_back({i, {&views.scans[i]}});
  for (KeyframeScans own : scans) {
    own.keyframe += views.poses.size();
    all.push_back(std::move(own));
  }
  return draw_grid(all, poses);
}

}  // namespace hybrid
