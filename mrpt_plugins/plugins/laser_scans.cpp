// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, the hybrid mapping authors

#include "mrpt_plugins/plugins/laser_scans.h"

#include <algorithm>
#include <cmath>
#include <memory>
#include <utility>

#include "libhybrid/factors/between.h"
#include "libhybrid/geometry/isometry.h"
#include "libhybrid/scans/scan_join.h"
#include "mrpt_plugins/bridge/pose_conversions.h"
#include "mrpt_plugins/bridge/poses.h"
#include "mrpt_plugins/mapping/register_plugin.h"

HYBRID_REGISTER_PLUGIN(LaserScans, hybrid)

namespace hybrid {
namespace {

/// What a planar match tells about height [m], roll and pitch [rad] in a map in space: that the
/// robot stands on the floor of a building.
constexpr double kHeight = 0.1;
constexpr double kTilt = 0.05;
/// Scans of the same time [s] and place are of several scanners. Time alone does not tell: clocks
/// that go back leave stamps that repeat.
constexpr double kSameTime = 1e-4;
constexpr double kSamePlace = 1e-9;
/// After so many matches of keyframes, the noise of odometry counts as measured also where a
/// keyframe matches nothing.
constexpr std::size_t kMeasured = 10;
/// A scan of fewer returns tells nothing.
constexpr std::size_t kFewReturns = 10;

bool are_together(const LaserScan& a, const LaserScan& b) {
  return std::abs(a.time - b.time) < kSameTime &&
         (a.T_keyframe_robot.matrix() - b.T_keyframe_robot.matrix()).cwiseAbs().maxCoeff() <
             kSamePlace;
}

SE2 planar_pose(const Values& values, Key key, bool is_3d) {
  return is_3d ? to_se2(to_isometry(values.at<SE3>(key))) : values.at<SE2>(key);
}

ContinuousFactorPtr factor_in_space(Key from, Key to, const UncertainMotion& measured) {
  const SE2& m = measured.motion;
  const SE3 motion(Eigen::Vector3d(m.x(), m.y(), 0.0),
                   SO3::exp(Eigen::Vector3d(0.0, 0.0, m.angle())));
  Eigen::MatrixXd covariance = planar_to_6d(measured.covariance);
  covariance.diagonal().segment<3>(2) << kHeight * kHeight, kTilt * kTilt, kTilt * kTilt;
  return std::make_shared<Between<SE3>>(from, to, motion, Noise::covariance(covariance));
}

ContinuousFactorPtr factor_in_plane(Key from, Key to, const UncertainMotion& measured) {
  return std::make_shared<BetweenSE2>(from, to, measured.motion,
                                      Noise::covariance(measured.covariance));
}

ContinuousFactorPtr factor_by_scans(Key from, Key to, const UncertainMotion& measured, bool is_3d) {
  return is_3d ? factor_in_space(from, to, measured) : factor_in_plane(from, to, measured);
}

/// What a robot has seen, in the frame of its first keyframe.
std::vector<StoredScans> places_of(const ScanMapper& mapper) {
  std::vector<StoredScans> out;
  for (LocalScans& scans : local_scans(mapper.tracker())) {
    out.push_back({mapper.relation(0, scans.anchor), std::move(scans.points)});
  }
  return out;
}

}  // namespace

void LaserScans::configure(IniSection section) {
  ScanTrackerOptions& tracker = options_.tracker;
  section.read("map_length", tracker.map_length,
               "way that a local map spans, with which scans are matched [m]", kPositiveLength);
  ScanClosureOptions& closures = options_.closures;
  closures.most_maps = section.get("closures", true, "whether to search for places seen before")
                           ? closures.most_maps
                           : 0;
  section.read("max_reach", closures.max_reach,
               "how far from where they should be such places are searched, at most [m]",
               kPositiveLength);
  section.read("max_range", options_.points.max_range, "longer rays are not used [m]",
               kPositiveLength);
}

/// The motion from the last frame with scans by odometry; empty at the first, and where odometry
/// does not tell.
std::optional<SE2> LaserScans::motion_to(const Robot& robot, const Frame& frame,
                                         const MapView& map) const {
  if (robot.keys.empty() || robot.lost_odometry) return std::nullopt;
  if (!map.values.contains(robot.keys.back())) return std::nullopt;
  return planar_pose(map.values, robot.keys.back(), map.is_3d)
      .between(to_se2(to_isometry(frame.T_map_robot)));
}

/// Tracks all scans of a frame; those of the last time make the keyframe. Notes where each was, in
/// the frame of the keyframe before.
TrackedScan LaserScans::track(Robot& robot, const Frame& frame, std::optional<SE2> from_before,
                              std::vector<SE2>& T_before_scan) {
  const std::vector<LaserScan>& scans = frame.scans;
  SE2 before;  // pose of the last scan in the frame of the keyframe
  if (from_before) before = from_before->inverse();
  for (std::size_t i = 0; i < scans.size();) {
    std::size_t end = i;
    std::vector<SurfacePoint> points;
    while (end < scans.size() && are_together(scans[end], scans[i])) {
      const std::vector<SurfacePoint> seen = scan_points(scans[end++], options_.points);
      points.insert(points.end(), seen.begin(), seen.end());
    }
    const SE2 place = to_se2(scans[i].T_keyframe_robot);
    const bool is_last = end == scans.size();
    ++robot.scans;
    if (points.size() < kFewReturns) ++robot.blind;
    // The keyframe sees the points of its last scan from where it is itself.
    if (is_last) points = transformed(place, points);
    std::optional<SE2> motion;
    const SE2 at = is_last ? SE2() : place;
    if (from_before || i > 0) motion = before.between(at);
    if (is_last) return robot.mapper.add(points, motion, KeyframeRule::kAlways);
    if (!robot.keys.empty()) {
      const TrackedScan tracked = robot.mapper.add(points, motion, KeyframeRule::kNever);
      T_before_scan.resize(end, tracked.T_before_scan);
      before = at;
      from_before = SE2();
    }
    i = end;
  }
  return {};
}

/// The same, of all scans of a frame or of none: where one throws, the next frame is matched as if
/// this one had had no scans.
TrackedScan LaserScans::track_all(Robot& robot, const Frame& frame, const MapView& map,
                                  std::vector<SE2>& T_before_scan) {
  const ScanMapper::Mark before = robot.mapper.mark();
  if (robot.keys.size() == robot.keys.capacity()) robot.keys.reserve(2 * robot.keys.size() + 1);
  try {
    const TrackedScan tracked = track(robot, frame, motion_to(robot, frame, map), T_before_scan);
    robot.keys.push_back(frame.pose);
    return tracked;
  } catch (...) {
    robot.mapper.roll_back(before);
    robot.is_next = false;
    throw;
  }
}

/// Of scans and keyframe, whose poses in the frame of the keyframe before are given.
ScanMotion LaserScans::motion_by(const Robot& robot, const TrackedScan& tracked,
                                 std::vector<SE2> T_before_scan) const {
  ScanMotion out;
  const SE2 T_keyframe_before = tracked.T_before_scan.inverse();
  for (SE2& pose : T_before_scan) pose = T_keyframe_before * pose;
  out.T_keyframe_robot = std::move(T_before_scan);
  if (!robot.is_next) return out;
  out.T_before_keyframe = tracked.T_before_scan;
  if (!robot.lost_odometry && (tracked.match || robot.matches >= kMeasured)) {
    out.odometry = tracked.odometry.measured;
  }
  return out;
}

void LaserScans::follow_closures(Robot& robot, const MapView& map, Contribution& out) const {
  const auto factor = [&](Key from, Key to, const UncertainMotion& measured) {
    return factor_by_scans(from, to, measured, map.is_3d);
  };
  hybrid::follow_closures(robot, concluded_ ? std::nullopt : std::optional(robot.keys.back()), map,
                          factor, out);
}

void LaserScans::expect(std::size_t robot, bool has_odometry) {
  motion_.reset();
  robot_ = robot;
  Robot& next = robots_.try_emplace(robot, options_).first->second;
  next.lost_odometry = next.lost_odometry || !has_odometry;
}

/// Whether a closure is accepted and in the map, where a window may have no room for it.
bool LaserScans::is_accepted(const Robot& robot, std::size_t closure) const {
  return robot.mapper.status(closure) == ClosureStatus::kAccepted && robot.factors.has(closure);
}

void LaserScans::refused() {
  for (auto& [number, robot] : robots_) robot.factors.forget();
}

Contribution LaserScans::observe(const Frame& frame, const MapView& map) {
  refused();  // what was asked before is settled
  motion_.reset();
  Robot& robot = robots_.try_emplace(robot_, options_).first->second;
  Contribution out;
  if (frame.scans.empty()) {
    robot.is_next = false;
    return out;
  }
  std::vector<SE2> T_before_scan;
  const TrackedScan tracked = track_all(robot, frame, map, T_before_scan);
  if (tracked.match) ++robot.matches;
  T_before_scan.resize(frame.scans.size(), tracked.T_before_scan);
  if (robot.keys.size() > 1) motion_ = motion_by(robot, tracked, std::move(T_before_scan));
  robot.is_next = true;
  robot.lost_odometry = false;
  if (tracked.match && map.holds(robot.keys[tracked.match->from])) {
    out.delta.continuous.push_back(factor_by_scans(robot.keys[tracked.match->from], frame.pose,
                                                   tracked.match->measured, map.is_3d));
  }
  follow_closures(robot, map, out);
  return out;
}

void LaserScans::applied(const Outcome& outcome) {
  for (auto& [number, robot] : robots_) robot.factors.applied(outcome);
}

Contribution LaserScans::conclude(const MapView& map) {
  refused();
  Contribution out;
  const bool is_first = !concluded_;
  concluded_ = true;
  for (auto& [number, robot] : robots_) {
    if (is_first) robot.mapper.finish();
    follow_closures(robot, map, out);
  }
  if (is_first && !map.is_3d) {
    const auto places = [](const Robot& robot) { return places_of(robot.mapper); };
    between_robots_ = tie_robots<SE2>(robots_, map, places, factor_in_plane, out);
  }
  return out;
}

std::vector<MeasuredClosure<SE2>> LaserScans::scan_closures() const {
  return measured_closures<SE2>(robots_);
}

void LaserScans::adopt_scans(std::size_t robot, const std::vector<StoredScans>& stored,
                             const UncertainMotion& start) {
  robots_.try_emplace(robot, options_).first->second.mapper.adopt(stored, start);
}

const ScanMapper* LaserScans::scan_mapper(std::size_t robot) const {
  const auto found = robots_.find(robot);
  return found == robots_.end() ? nullptr : &found->second.mapper;
}

std::vector<LocalScans> LaserScans::local_scans() const {
  std::vector<LocalScans> out;
  for (const auto& [number, robot] : robots_) {
    for (LocalScans& scans : hybrid::local_scans(robot.mapper.tracker())) {
      scans.anchor = static_cast<std::size_t>(robot.keys[scans.anchor].index());
      out.push_back(std::move(scans));
    }
  }
  return out;
}

std::map<std::string, double> LaserScans::statistics() const {
  double maps = 0, closures = 0, accepted = 0, lost = 0, translation = 0, rotation = 0;
  double scans = 0, blind = 0, carried = 0, places = 0, places_accepted = 0;
  OdometryCalibration2 calibration(1, 1, 0);
  for (const auto& [number, robot] : robots_) {
    const ScanTracker& tracker = robot.mapper.tracker();
    for (std::size_t k = 0; k < robot.mapper.closures().size(); ++k) {
      const ScanClosure& closure = robot.mapper.closures()[k];
      const double searches = 1.0 / closure.modes;  // of whose modes one is right at most
      (closure.is_known ? places : closures) += closure.is_known ? searches : 1.0;
      if (is_accepted(robot, k)) ++(closure.is_known ? places_accepted : accepted);
    }
    maps += double(tracker.local_maps().size());
    lost += double(tracker.lost());
    carried += double(tracker.carried());
    scans += double(robot.scans);
    blind += double(robot.blind);
    translation = std::max(translation, tracker.odometry_noise().translation_scale());
    rotation = std::max(rotation, tracker.odometry_noise().rotation_scale());
    const OdometryCalibration2 own = tracker.odometry_noise().calibration();
    const OdometryCalibration2 none(1, 1, 0);
    for (int i = 0; i < 3; ++i) {
      if (std::abs(own[i] - none[i]) > std::abs(calibration[i] - none[i])) calibration[i] = own[i];
    }
  }
  return {{"local_maps", maps},
          {"known_places", std::round(places)},
          {"known_places_accepted", places_accepted},
          {"scan_closures", closures},
          {"closures_between_robots", static_cast<double>(between_robots_)},
          {"scan_closures_accepted", accepted},
          {"scans", scans},
          {"scans_blind", blind},
          {"scans_lost", lost},
          {"scans_carried", carried},
          {"odometry_translation_scale", translation},
          {"odometry_rotation_scale", rotation},
          {"odometry_times_translation", calibration[0]},
          {"odometry_times_rotation", calibration[1]},
          {"odometry_drift_deg_per_m", calibration[2] * 180 / M_PI}};
}

}  // namespace hybrid
