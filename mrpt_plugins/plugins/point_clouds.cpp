// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, the hybrid mapping authors

#include "mrpt_plugins/plugins/point_clouds.h"

#include <algorithm>
#include <cmath>
#include <memory>
#include <set>
#include <utility>

#include "libhybrid/clouds/cloud_join.h"
#include "libhybrid/core/error.h"
#include "libhybrid/core/spatial_values.h"
#include "libhybrid/factors/between.h"
#include "libhybrid/geometry/isometry.h"
#include "libhybrid/io/read_graph.h"
#include "libhybrid/pose_graph/pose_graph.h"
#include "mrpt_plugins/bridge/poses.h"
#include "mrpt_plugins/mapping/register_plugin.h"

HYBRID_REGISTER_PLUGIN(PointClouds, hybrid)

namespace hybrid {
namespace {

/// Of odometry where the map does not tell it before it is solved.
Matrix6 usual_covariance(const SE3& motion) {
  return usual_motion_covariance(motion.translation().norm(), motion.rotation().log().norm());
}

ContinuousFactorPtr factor_of(Key from, Key to, const UncertainMotion3& motion) {
  return std::make_shared<Between<SE3>>(from, to, motion.motion,
                                        Noise::covariance(motion.covariance));
}

/// Those of a local map, which may still grow.
const std::vector<CloudPoint>& local_points(const LocalCloud& map, const CloudTracker& tracker) {
  const bool grows = &map == &tracker.local_maps().back() && tracker.surfaces() != nullptr;
  return grows ? tracker.surfaces()->points() : map.points;
}

/// All clouds of a frame as one, whose stamp is that of the first.
PointCloud clouds_of(const Frame& frame, DropReport& dropped) {
  PointCloud out;
  for (const auto& observation : frame.observations) {
    auto cloud = cloud_in(*observation, dropped);
    if (!cloud) continue;
    if (out.points.empty()) {
      out = std::move(*cloud);
      continue;
    }
    const auto later = static_cast<float>(cloud->stamp - out.stamp);
    for (float& time : cloud->times) time += later;
    if (!cloud->times.empty() || !out.times.empty()) {
      out.times.resize(out.points.size());  // 0: as if at the stamp
      cloud->times.resize(cloud->points.size());
    }
    out.times.insert(out.times.end(), cloud->times.begin(), cloud->times.end());
    out.points.insert(out.points.end(), cloud->points.begin(), cloud->points.end());
  }
  return out;
}

/// Whether a frame has a cloud in which nothing was seen.
bool sees_nothing(const Frame& frame) {
  return std::any_of(frame.observations.begin(), frame.observations.end(),
                     [](const auto& observation) { return is_empty_cloud(*observation); });
}

/// Edges of a graph between poses that do not follow each other; its poses count clouds.
std::vector<ProposedClosure> closures_of(const std::string& path) {
  const PoseGraph graph = hybrid::read_graph(path);
  std::set<Key> poses;
  for (const GraphEdge<SE3>& edge : graph.poses3) poses.insert({edge.from, edge.to});
  std::map<Key, std::size_t> cloud;
  for (const Key key : poses) cloud.emplace(key, cloud.size());
  std::vector<ProposedClosure> out;
  for (const GraphEdge<SE3>& edge : graph.poses3) {
    const std::size_t from = cloud.at(edge.from), to = cloud.at(edge.to);
    if (from + 1 == to || to + 1 == from) continue;
    if (from < to) {
      out.push_back({from, to, edge.measured});
    } else {
      out.push_back({to, from, edge.measured.inverse()});
    }
  }
  return out;
}

/// Counts by reason what was proposed and not tried.
void tell_proposed(const ProposedCount& count, DropReport& dropped) {
  const std::pair<const char*, std::size_t> reasons[] = {
      {"candidate not tried: one local map has both clouds, or two that overlap", count.near},
      {"candidate not tried: no surface was seen at one of its clouds", count.blind},
      {"candidate not tried: its pair of clouds is proposed twice", count.repeated},
      {"candidate not tried: the log has fewer clouds", count.absent}};
  for (const auto& [reason, number] : reasons) {
    if (number > 0) dropped[reason] += number;
  }
}

}  // namespace

CloudFollower* cloud_follower_of(const std::vector<std::shared_ptr<MappingPlugin>>& plugins) {
  for (const auto& plugin : plugins) {
    if (auto* follower = dynamic_cast<CloudFollower*>(plugin.get())) return follower;
  }
  return nullptr;
}

void PointClouds::configure(IniSection section) {
  CloudTrackerOptions& tracker = options_.tracker;
  section.read("spacing", tracker.spacing,
               "of the points that are kept, as a share of the reach: the median distance of what "
               "the sensor sees",
               {1e-3, 0.5});
  section.read("map_length", tracker.map_length,
               "way that a local map spans, with which clouds are matched, in reaches", {0.1, 1e3});
  CloudClosureOptions& closures = options_.closures;
  closures.most_maps = section.get("closures", true, "whether to search for places seen before")
                           ? closures.most_maps
                           : 0;
  section.read("max_reach", closures.max_reach,
               "how far from where they should be such places are searched, at most, in reaches",
               {0.01, 1e3});
  const std::string candidates =
      section.path("candidates", "",
                   "g2o file with a pose for each cloud, whose edges between poses that do not "
                   "follow each other "
                   "are tried as closures, besides those that are found");
  if (!candidates.empty()) closures.proposed = closures_of(candidates);
}

std::vector<std::string> PointClouds::observation_classes() const {
  return {"CObservationPointCloud"};
}

std::vector<std::string> PointClouds::uses() const {
  return {"CObservationPointCloud", "CObservation3DRangeScan", "CObservationVelodyneScan"};
}

/// Where there are planar scans, these are mapped.
bool PointClouds::suits(const LogContents& log) const {
  return log.scans == 0 && MappingPlugin::suits(log);
}

/// The motion from the last frame with a cloud by odometry; nothing at the first, and where
/// odometry does not tell.
std::optional<UncertainMotion3> PointClouds::motion_to(const Robot& robot, const Frame& frame,
                                                       const MapView& map) const {
  if (robot.keys.empty() || robot.lost_odometry || !map.holds(robot.keys.back())) {
    return std::nullopt;
  }
  const Key before = robot.keys.back();
  const SE3 motion = map.values.at<SE3>(before).between(to_se3(to_isometry(frame.T_map_robot)));
  if (!motion.translation().allFinite()) return std::nullopt;
  UncertainMotion3 out{motion, usual_covariance(motion)};
  try {
    const Matrix6 known = covariance_of_motion(frame.view(), before, map);
    if (known.allFinite() && known.llt().info() == Eigen::Success) out.covariance = known;
  } catch (const SettingsError&) {
    // a batch back-end, which solves at the end
  }
  return out;
}

/// Adds a cloud as it would have been seen at its stamp; before the second one the first, whose
/// motion no cloud before it tells.
TrackedCloud PointClouds::add(Robot& robot, PointCloud cloud,
                              const std::optional<UncertainMotion3>& odometry) const {
  std::optional<SE3> motion;
  if (odometry) motion = odometry->motion;
  if (robot.first && !motion) {
    CloudTracker both(options_.tracker);
    both.track(robot.first->points, robot.first->sensor, std::nullopt, true);
    const TrackedCloud next = both.track(cloud.points, cloud.sensor, std::nullopt, true);
    if (next.match) motion = next.T_before_cloud;
  }
  const SE3::Tangent velocity = robot.velocity.at(cloud.stamp, motion);
  add_first(robot, velocity);
  const bool has_times = !cloud.times.empty();
  const TrackedCloud tracked = robot.mapper.add(
      deskewed(std::move(cloud.points), cloud.times, velocity), cloud.sensor, odometry, has_times);
  robot.velocity.add(cloud.stamp,
                     tracked.match ? std::optional(tracked.T_before_cloud) : std::nullopt);
  return tracked;
}

void PointClouds::add_first(Robot& robot, const SE3::Tangent& velocity) {
  if (!robot.first) return;
  robot.mapper.add(deskewed(robot.first->points, robot.first->times, velocity), robot.first->sensor,
                   std::nullopt, true);
  robot.first.reset();
}

Contribution PointClouds::observe(const Frame& frame, const MapView& map) {
  refused();  // what was asked before is settled
  Contribution out;
  Robot& robot = robots_.try_emplace(frame.robot, options_).first->second;
  robot.lost_odometry = robot.lost_odometry || !frame.has_odometry;
  PointCloud cloud = clouds_of(frame, out.dropped);
  if (cloud.points.empty()) {
    if (sees_nothing(frame)) ++robot.empty;
    return out;
  }
  if (!map.is_3d) {
    ++out.dropped["cloud dropped: the map is planar ([map] dimension)"];
    return out;
  }
  if (cloud.points == robot.last) {
    ++out.dropped["cloud dropped: it is the one before once more, point by point"];
    return out;
  }
  robot.last = cloud.points;
  TrackedCloud tracked;
  try {
    const std::optional<UncertainMotion3> odometry = motion_to(robot, frame, map);
    if (robot.keys.empty() && !cloud.times.empty()) {
      robot.velocity.add(cloud.stamp, std::nullopt);
      robot.first = std::move(cloud);
    } else {
      tracked = add(robot, std::move(cloud), odometry);
    }
    robot.keys.push_back(frame.pose);
  } catch (...) {
    robots_.erase(frame.robot);  // the next cloud begins anew
    throw;
  }
  robot.lost_odometry = false;
  if (tracked.match && map.holds(robot.keys[tracked.match->from])) {
    out.delta.continuous.push_back(
        factor_of(robot.keys[tracked.match->from], frame.pose, tracked.match->measured));
  }
  follow_closures(robot, map, out);
  return out;
}

void PointClouds::follow_closures(Robot& robot, const MapView& map, Contribution& out) const {
  hybrid::follow_closures(robot, concluded_ ? std::nullopt : std::optional(robot.keys.back()), map,
                          factor_of, out);
}

void PointClouds::applied(const Outcome& outcome) {
  for (auto& [number, robot] : robots_) robot.factors.applied(outcome);
}

void PointClouds::refused() {
  for (auto& [number, robot] : robots_) robot.factors.forget();
}

Contribution PointClouds::conclude(const MapView& map) {
  refused();
  Contribution out;
  const bool is_first = !std::exchange(concluded_, true);
  for (auto& [number, robot] : robots_) {
    add_first(robot, SE3::Tangent::Zero());
    if (is_first) {
      robot.mapper.finish();
      tell_proposed(robot.mapper.proposed(), out.dropped);
    }
    follow_closures(robot, map, out);
  }
  if (is_first && map.is_3d) {
    const auto places = [this](const Robot& robot) { return places_of(robot); };
    between_robots_ = tie_robots<SE3>(robots_, map, places, factor_of, out);
  }
  return out;
}

void PointClouds::adopt_clouds(std::size_t robot, const std::vector<StoredCloud>& stored,
                               const UncertainMotion3& start) {
  robots_.try_emplace(robot, options_).first->second.mapper.adopt(stored, start);
}

const CloudMapper* PointClouds::cloud_mapper(std::size_t robot) const {
  const auto found = robots_.find(robot);
  return found == robots_.end() ? nullptr : &found->second.mapper;
}

/// What a robot has seen, in the frame of its first cloud.
std::vector<StoredCloud> PointClouds::places_of(const Robot& robot) const {
  const CloudTracker& tracker = robot.mapper.tracker();
  std::vector<StoredCloud> out;
  for (const LocalCloud& map : tracker.local_maps()) {
    out.push_back({robot.mapper.relation(0, map.anchor), local_points(map, tracker),
                   options_.tracker.spacing * tracker.reach()});
  }
  return out;
}

std::vector<MeasuredClosure<SE3>> PointClouds::cloud_closures() const {
  return measured_closures<SE3>(robots_);
}

std::vector<LocalView> PointClouds::local_views() const {
  std::vector<LocalView> out;
  for (const auto& [number, robot] : robots_) {
    const CloudTracker& tracker = robot.mapper.tracker();
    for (const LocalCloud& map : tracker.local_maps()) {
      out.push_back({static_cast<std::size_t>(robot.keys[map.anchor].index()),
                     local_points(map, tracker), options_.tracker.spacing * tracker.reach()});
    }
  }
  return out;
}

/// What became of closures that others have found; nothing where there are none.
std::map<std::string, double> PointClouds::candidate_statistics() const {
  if (options_.closures.proposed.empty()) return {};
  double matched = 0, unmatched = 0, same = 0, not_tried = 0;
  for (const auto& [number, robot] : robots_) {
    const ProposedCount count = robot.mapper.proposed();
    matched += static_cast<double>(count.matched);
    unmatched += static_cast<double>(count.unmatched);
    same += static_cast<double>(count.same);
    not_tried += static_cast<double>(count.near + count.blind + count.repeated + count.absent);
  }
  return {{"cloud_candidates", matched + unmatched + same + not_tried},
          {"cloud_candidates_matched", matched},
          {"cloud_candidates_unmatched", unmatched},
          {"cloud_candidates_same", same},
          {"cloud_candidates_not_tried", not_tried}};
}

std::map<std::string, double> PointClouds::statistics() const {
  double clouds = 0, lost = 0, blind = 0, maps = 0, closures = 0, accepted = 0;
  double places = 0, places_accepted = 0, sweep = 0;
  for (const auto& [number, robot] : robots_) {
    const CloudTracker& tracker = robot.mapper.tracker();
    clouds += static_cast<double>(tracker.clouds() + robot.empty);
    lost += static_cast<double>(tracker.lost());
    blind += static_cast<double>(tracker.blind() + robot.empty);
    sweep += tracker.sweep().share() / static_cast<double>(robots_.size());
    maps += static_cast<double>(tracker.local_maps().size());
    for (std::size_t k = 0; k < robot.mapper.closures().size(); ++k) {
      const CloudClosure& closure = robot.mapper.closures()[k];
      // Of the modes of one search one is right at most.
      (closure.is_known ? places : closures) += closure.is_known ? 1.0 / closure.modes : 1.0;
      if (robot.factors.has(k)) ++(closure.is_known ? places_accepted : accepted);
    }
  }
  std::map<std::string, double> out{
      {"clouds", clouds},
      {"clouds_blind", blind},
      {"clouds_lost", lost},
      {"cloud_maps", maps},
      {"cloud_sweep", sweep},
      {"cloud_closures", closures},
      {"cloud_closures_accepted", accepted},
      {"closures_between_robots", static_cast<double>(between_robots_)},
      {"known_places", std::round(places)},
      {"known_places_accepted", places_accepted}};
  out.merge(candidate_statistics());
  return out;
}

}  // namespace hybrid
