// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, the hybrid mapping authors

#include "mrpt_plugins/session/detail/meeting.h"

#include <algorithm>
#include <utility>

#include "libhybrid/clouds/cloud_join.h"
#include "libhybrid/core/key_letters.h"
#include "libhybrid/detections/sighting.h"
#include "libhybrid/maps/align_frames.h"
#include "libhybrid/maps/join_maps.h"
#include "mrpt_plugins/bridge/about_file.h"
#include "mrpt_plugins/bridge/pose_conversions.h"
#include "mrpt_plugins/map_file/export_map.h"
#include "mrpt_plugins/session/detail/open_logs.h"
#include "mrpt_plugins/session/map_run.h"
#include "mrpt_plugins/session/scan_places.h"

namespace hybrid {
namespace {

/// Standard deviations of a start that is to be measured again [m], [rad].
constexpr double kRoughly = 0.5;
constexpr double kRoughTurn = 0.1;

/// Where a robot was at a time; nothing before its first and after its last pose.
std::optional<Eigen::Vector3d> position_at(const Trajectory& trajectory, double time) {
  const auto after = std::lower_bound(trajectory.begin(), trajectory.end(), time,
                                      [](const auto& pose, double t) { return pose.time < t; });
  if (after == trajectory.end() || (after == trajectory.begin() && time < after->time)) {
    return std::nullopt;
  }
  const Eigen::Vector3d to = to_isometry(after->pose).translation();
  if (after == trajectory.begin()) return to;
  const auto before = after - 1;
  const Eigen::Vector3d from = to_isometry(before->pose).translation();
  return from + (time - before->time) / (after->time - before->time) * (to - from);
}

}  // namespace

Meeting::Meeting(const ReplayRequest& request, const ReplaySettings& settings, MapRecord joint)
    : request_(request), odds_(settings.map.odds) {
  for (const RobotSettings& robot : settings.robots) {
    ids_.push_back(settings.sightings ? robot.options.id : std::nullopt);
  }
  if (joint.landmarks.empty()) {
    joint = own(0).map;
    place(0, Eigen::Isometry3d::Identity());
  }
  parts_.push_back({std::move(joint), Eigen::Isometry3d::Identity()});
}

std::optional<FoundStart> Meeting::find(std::size_t i) {
  auto start = by_landmarks(i);
  const bool is_by_places = !start && (start = by_places(i)).has_value();
  if (!start) start = by_sightings(i);
  if (!start) start = by_fixes(i);
  if (!start) return std::nullopt;
  place(i, start->T_map_robot);
  // Fixes move the first pose from the origin.
  if (own(i).map.origin) {
    start->T_map_robot = start->T_map_robot * to_isometry(own(i).trajectory.front().pose);
  }
  return FoundStart{*start, own(i).trajectory.size() - 1, is_by_places};
}

const Meeting::OwnMap& Meeting::own(std::size_t i) {
  const auto it = maps_.find(i);
  return it != maps_.end() ? it->second : maps_.emplace(i, map_alone(i)).first->second;
}

Meeting::OwnMap Meeting::map_alone(std::size_t robot) const {
  const auto ini = open_config(request_);
  ReplaySettings settings = read_settings(*ini, request_);
  settings.robots = {std::move(settings.robots[robot])};
  RobotSettings& own = settings.robots.front();
  LogMerge log = open_logs(settings);
  own.options.motion.start = given_start(own.start, log.is_3d());
  const Plugins plugins = settings.plugins;
  Mapper mapper = make_mapper(settings, log.is_3d());
  return about({own.rawlog}, [&] {
    OwnMap out;
    while (const auto keyframe = log.next()) {
      throw_if_interrupted();
      if (mapper.add(*keyframe) == nullptr) continue;
      out.robots.push_back(keyframe->robots);
    }
    mapper.finish();
    const MapResult result = mapper.result();
    out.map = record_of(mapper, result);
    SeenPlaces seen = seen_places(plugins, result, mapper);
    out.map.local_maps = std::move(seen.local_maps);
    out.map.local_clouds = std::move(seen.local_clouds);
    out.trajectory = result.trajectory;
    if (result.datum && result.datum->is_on_earth) set_origin(*result.datum, mapper, out);
    return out;
  });
}

/// Notes the place on earth of the map that a robot makes alone, and how well its start is known
/// there.
void Meeting::set_origin(const MapDatum& datum, const Mapper& mapper, OwnMap& out) {
  const Key first(key_letter::kPose, 0);
  const auto covariances = mapper.backend().uncertainty({first}, {}).covariances;
  const auto known = covariances.find(first);
  if (known == covariances.end()) return;
  out.map.origin = origin_of(datum);
  out.covariance = known->second;
}

/// By landmarks that its map has in common with those of others, which then are one map.
std::optional<KnownStart> Meeting::by_landmarks(std::size_t i) {
  const MapRecord& map = own(i).map;
  for (Part& part : parts_) {
    if (map.landmarks.empty() || part.map.landmarks.empty()) continue;
    auto joined = join_maps(part.map, map, odds_);
    if (!joined) continue;
    part.map = std::move(joined->map);
    return KnownStart{part.T_joint_part * joined->T_first_second,
                      joined->variance_factor * joined->covariance};
  }
  return std::nullopt;
}

/// By what laser scans, or clouds, of both saw.
std::optional<KnownStart> Meeting::by_places(std::size_t i) {
  const MapRecord& map = own(i).map;
  for (Part& part : parts_) {
    std::string why;
    auto joined = join_maps_by_places(part.map, map, odds_, why);
    if (!joined) continue;
    part.map = std::move(joined->map);
    // What was seen tells it exactly once more, in the joint map.
    Eigen::VectorXd sigmas = Eigen::VectorXd::Constant(joined->covariance.rows(), kRoughly);
    sigmas.tail(map.is_3d ? 3 : 1).setConstant(kRoughTurn);
    return KnownStart{part.T_joint_part * joined->T_first_second, sigmas.cwiseAbs2().asDiagonal()};
  }
  return std::nullopt;
}

/// By where it saw others, and others saw it, while both knew where they were in their own maps.
std::optional<KnownStart> Meeting::by_sightings(std::size_t i) {
  std::vector<CommonPoint> points;
  for (const auto& [j, T_joint_other] : placed_) {
    for (const auto& [a, b] : sightings(j, i)) points.push_back({T_joint_other * a, b});
    for (const auto& [a, b] : sightings(i, j)) points.push_back({T_joint_other * b, a});
  }
  const MapRecord& map = own(i).map;
  const auto aligned = align_frames(points, map.is_3d, odds_);
  if (!aligned) return std::nullopt;
  parts_.push_back({map, aligned->T_first_second});
  return KnownStart{aligned->T_first_second, aligned->covariance};
}

/// By the places on earth of the maps.
std::optional<KnownStart> Meeting::by_fixes(std::size_t i) {
  const OwnMap& alone = own(i);
  for (const Part& part : parts_) {
    const auto T = motion_by_fixes(part.map.origin, alone.map.origin, alone.map.is_3d);
    if (!T) continue;
    const Eigen::Isometry3d T_joint_own = part.T_joint_part * *T;
    parts_.push_back({alone.map, T_joint_own});
    return KnownStart{T_joint_own, alone.covariance};
  }
  return std::nullopt;
}

/// Where a robot saw another in its own map, and where that was in its own then.
std::vector<CommonPoint> Meeting::sightings(std::size_t observer, std::size_t other) {
  const OwnMap& sees = own(observer);
  const OwnMap& seen = own(other);
  std::vector<CommonPoint> out;
  for (std::size_t k = 0; ids_[other] && k < sees.trajectory.size(); ++k) {
    const TimedPose& pose = sees.trajectory[k];
    const auto there = position_at(seen.trajectory, pose.time);
    for (const DetectionFrame& frame : sees.robots[k]) {
      if (!there || !misfit(frame, sees.map.is_3d).empty()) continue;
      for (const Detection& detection : frame.detections) {
        if (detection.id != ids_[other]) continue;
        out.push_back({sighted_point(to_isometry(pose.pose), frame, detection), *there});
      }
    }
  }
  return out;
}

}  // namespace hybrid
