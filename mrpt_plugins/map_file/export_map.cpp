// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, the hybrid mapping authors

#include "mrpt_plugins/map_file/export_map.h"

#include <fmt/format.h>

#include <GeographicLib/LocalCartesian.hpp>
#include <algorithm>
#include <cmath>
#include <memory>
#include <nlohmann/json.hpp>

#include "libhybrid/core/error.h"
#include "libhybrid/discrete/probabilities.h"
#include "mrpt_plugins/bridge/pose_conversions.h"
#include "mrpt_plugins/map_file/stored_views.h"

namespace hybrid {
namespace {

using Json = nlohmann::ordered_json;

double probability(double log_odds) {
  return 1 / (1 + std::exp(-log_odds));
}

/// Points of the map as longitude and latitude.
class Globe {
 public:
  explicit Globe(const MapOrigin& origin)
      : local_(origin.latitude, origin.longitude),
        turn_(Eigen::AngleAxisd(origin.direction * M_PI / 180, Eigen::Vector3d::UnitZ())) {}

  Json operator()(const Eigen::Vector3d& point) const {
    const Eigen::Vector3d p = turn_ * point;
    double latitude = 0, longitude = 0, height = 0;
    local_.Reverse(p.x(), p.y(), p.z(), latitude, longitude, height);
    return Json::array({longitude, latitude});
  }

 private:
  GeographicLib::LocalCartesian local_;
  Eigen::Matrix3d turn_;
};

}  // namespace

std::vector<MapWay> ways_of(const MapRecord& map) {
  std::vector<MapWay> out;
  for (const MapSession& session : map.sessions) {
    const std::size_t first = out.size();
    for (const std::string& robot : session.robots) out.push_back({session.id, robot, {}});
    if (session.robots.empty()) out.push_back({session.id, "", {}});
    for (const MapKeyframe& k : session.keyframes) {
      out[first + k.robot].poses.push_back({k.time, to_mrpt(k.T_map_robot)});
    }
  }
  return out;
}

MapResult result_of(const MapRecord& map, const std::string& title) {
  MapResult out;
  out.title = title;
  out.is_3d = map.is_3d;
  out.in_known_map = true;
  out.class_names = map.class_names;
  const std::vector<MapWay> ways = ways_of(map);
  for (const MapWay& way : ways) {
    const bool is_session = way.robot.empty();
    const std::string name = is_session ? fmt::format("session {}", way.session) : way.robot;
    RobotPath path{name, {}, is_session};
    for (const TimedPose& pose : way.poses) {
      path.keyframes.push_back(out.trajectory.size());
      out.trajectory.push_back(pose);
    }
    out.robots.push_back(std::move(path));
  }
  if (ways.size() == 1 && ways.front().robot.empty()) out.robots.clear();
  for (const MapLandmark& l : map.landmarks) {
    if (!exists(l)) continue;
    LandmarkEstimate landmark;
    landmark.id = l.id;
    landmark.position = l.position;
    landmark.covariance = l.covariance;
    landmark.is_3d = map.is_3d;
    landmark.class_probabilities = l.class_probabilities;
    if (const int best = most_probable(l.class_probabilities); best >= 0) {
      landmark.class_index = best;
    }
    landmark.sightings = l.sightings;
    landmark.size = l.size;
    out.landmarks.push_back(std::move(landmark));
  }
  GridMap grid = draw_grid(stored_views(map), {}, {});
  if (!grid.empty()) out.grid = std::make_shared<const GridMap>(std::move(grid));
  return out;
}

std::string geojson_text(const MapRecord& map, const MapOrigin& origin) {
  const Globe globe(origin);
  Json features = Json::array();
  for (const MapLandmark& l : map.landmarks) {
    if (!exists(l)) continue;
    Json properties = {{"id", l.id},
                       {"existence", probability(l.existence)},
                       {"sightings", l.sightings},
                       {"sigma_m", std::sqrt(l.covariance.trace() / map.dim())}};
    const int best = most_probable(l.class_probabilities);
    if (l.size.extent > 0) properties["extent_m"] = l.size.extent;
    if (l.size.things > 1) properties["things"] = l.size.things;
    if (best >= 0) properties["class"] = map.class_names[static_cast<std::size_t>(best)];
    features.push_back({{"type", "Feature"},
                        {"geometry", {{"type", "Point"}, {"coordinates", globe(l.position)}}},
                        {"properties", std::move(properties)}});
  }
  for (const MapWay& way : ways_of(map)) {
    if (way.poses.size() < 2) continue;
    Json line = Json::array();
    for (const TimedPose& pose : way.poses) line.push_back(globe(point_of(pose.pose)));
    const auto session = std::find_if(map.sessions.begin(), map.sessions.end(),
                                      [&](const MapSession& s) { return s.id == way.session; });
    Json properties = {{"session", way.session}, {"mode", session->mode}};
    if (!way.robot.empty()) properties["robot"] = way.robot;
    features.push_back({{"type", "Feature"},
                        {"geometry", {{"type", "LineString"}, {"coordinates", std::move(line)}}},
                        {"properties", std::move(properties)}});
  }
  const Json all = {{"type", "FeatureCollection"}, {"features", std::move(features)}};
  return all.dump(1) + "\n";
}

std::string pcd_text(const MapRecord& map) {
  std::string rows;
  std::size_t count = 0;
  for (const MapLandmark& l : map.landmarks) {
    if (!exists(l)) continue;
    ++count;
    rows += fmt::format("{} {} {} {} {}\n", l.position.x(), l.position.y(), l.position.z(),
                        most_probable(l.class_probabilities), l.id);
  }
  return fmt::format(
      "# .PCD v0.7 - Point Cloud Data file format\nVERSION 0.7\nFIELDS x y z class id\n"
      "SIZE 4 4 4 4 4\nTYPE F F F I I\nCOUNT 1 1 1 1 1\nWIDTH {0}\nHEIGHT 1\n"
      "VIEWPOINT 0 0 0 1 0 0 0\nPOINTS {0}\nDATA ascii\n{1}",
      count, rows);
}

}  // namespace hybrid
