// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, the hybrid mapping authors

#include "mrpt_plugins/map_file/export_map.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <memory>
#include <nlohmann/json.hpp>
#include <utility>

#include "libhybrid/clouds/cloud_join.h"
#include "libhybrid/core/error.h"
#include "libhybrid/discrete/probabilities.h"
#include "libhybrid/geometry/isometry.h"
#include "mrpt_plugins/bridge/geodesy.h"
#include "mrpt_plugins/bridge/pose_conversions.h"
#include "mrpt_plugins/map_file/stored_views.h"
#include "mrpt_plugins/output/cloud_writer.h"
#include "mrpt_plugins/output/fix_writer.h"
#include "mrpt_plugins/output/map_style.h"

namespace hybrid {
namespace {

using Json = nlohmann::ordered_json;

constexpr double kDegree = M_PI / 180;

double probability(double log_odds) {
  return 1 / (1 + std::exp(-log_odds));
}

/// Points of the map as longitude and latitude.
class Globe {
 public:
  explicit Globe(const MapOrigin& origin)
      : local_({origin.latitude, origin.longitude, origin.altitude}),
        turn_(Eigen::AngleAxisd(origin.direction * kDegree, Eigen::Vector3d::UnitZ())) {}

  Json operator()(const Eigen::Vector3d& point) const {
    const GeodeticPoint p = local_.to_geodetic(turn_ * point);
    return Json::array({rounded(p.longitude), rounded(p.latitude)});
  }

 private:
  /// To a tenth of a millimetre.
  static double rounded(double degrees) { return std::round(degrees * 1e9) / 1e9; }

  LocalFrame local_;
  Eigen::Matrix3d turn_;
};

Json feature(const char* type, Json coordinates, Json properties) {
  return {{"type", "Feature"},
          {"geometry", {{"type", type}, {"coordinates", std::move(coordinates)}}},
          {"properties", std::move(properties)}};
}

Json line_feature(const Globe& globe, const std::vector<Eigen::Vector3d>& path, Json properties) {
  Json line = Json::array();
  for (const Eigen::Vector3d& point : path) line.push_back(globe(point));
  return feature("LineString", std::move(line), std::move(properties));
}

/// The file: a feature a line. RFC 7946 has no other coordinates than these; a member of its own
/// says which.
std::string collection(const std::vector<Json>& features) {
  std::string text =
      "{\"type\": \"FeatureCollection\", \"crs_name\": \"OGC:CRS84\", \"description\": "
      "\"longitude and latitude by WGS 84 [deg]\", \"features\": [";
  for (const Json& one : features) {
    text += (&one == &features.front() ? "\n" : ",\n") +
            one.dump(-1, ' ', false, Json::error_handler_t::replace);
  }
  return text + "\n]}\n";
}

void add_size(const LandmarkSize& size, Json& properties) {
  if (size.extent > 0) properties["extent_m"] = size.extent;
  if (size.things > 1) properties["things"] = size.things;
}

Json fix_feature(const Globe& globe, const FixEstimate& fix) {
  Json properties = {{"fix", fix.mode ? to_string(*fix.mode) : "not used"}, {"time", fix.time}};
  if (!fix.unused.empty()) properties["reason"] = fix.unused;
  const auto& p = fix.probabilities;
  if (p[0] + p[1] + p[2] > 0) {
    properties["p_good"] = p[0];
    properties["p_biased"] = p[1];
    properties["p_false"] = p[2];
  }
  return feature("Point", globe(fix.measured), std::move(properties));
}

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
  std::vector<CloudPoint> cloud = surfaces_of(stored_clouds(map));
  if (!cloud.empty()) {
    if (grid.empty()) grid = cloud_grid(cloud);
    out.cloud = std::make_shared<const std::vector<CloudPoint>>(std::move(cloud));
  }
  if (!grid.empty()) out.grid = std::make_shared<const GridMap>(std::move(grid));
  return out;
}

MapOrigin origin_of(const MapDatum& datum) {
  constexpr double kArm = 100;  // m, along the x axis
  const LocalFrame frame(datum.origin);
  const auto place = [&](double x) {
    return frame.to_geodetic(datum.T_datum_map * Eigen::Vector3d(x, 0, 0));
  };
  const GeodeticPoint origin = place(0);
  const Eigen::Vector3d arm = LocalFrame(origin).to_local(place(kArm));
  return {origin.latitude, origin.longitude, std::atan2(arm.y(), arm.x()) / kDegree,
          origin.altitude, true};
}

MapDatum datum_of(const MapOrigin& origin) {
  MapDatum out{{origin.latitude, origin.longitude, origin.altitude}, true, {}};
  out.T_datum_map = Eigen::AngleAxisd(origin.direction * kDegree, Eigen::Vector3d::UnitZ());
  return out;
}

std::optional<Eigen::Isometry3d> motion_by_fixes(const std::optional<MapOrigin>& first,
                                                 const std::optional<MapOrigin>& second,
                                                 bool is_3d) {
  if (!first || !second || !first->by_fixes || !second->by_fixes) return std::nullopt;
  const MapDatum from = datum_of(*first), to = datum_of(*second);
  const Eigen::Isometry3d T = from.T_datum_map.inverse() *
                              LocalFrame(to.origin).pose_in(LocalFrame(from.origin)) *
                              to.T_datum_map;
  return is_3d ? T : to_isometry(to_se2(T));
}

std::string geojson_text(const MapRecord& map, const MapOrigin& origin) {
  const Globe globe(origin);
  std::vector<Json> features;
  for (const MapLandmark& l : map.landmarks) {
    if (!exists(l)) continue;
    Json properties = {{"id", l.id},
                       {"existence", probability(l.existence)},
                       {"sightings", l.sightings},
                       {"sigma_m", std::sqrt(l.covariance.trace() / map.dim())}};
    const int best = most_probable(l.class_probabilities);
    add_size(l.size, properties);
    if (best >= 0) properties["class"] = map.class_names[static_cast<std::size_t>(best)];
    features.push_back(feature("Point", globe(l.position), std::move(properties)));
  }
  for (const MapWay& way : ways_of(map)) {
    if (way.poses.size() < 2) continue;
    const auto session = std::find_if(map.sessions.begin(), map.sessions.end(),
                                      [&](const MapSession& s) { return s.id == way.session; });
    Json properties = {{"session", way.session}, {"mode", session->mode}};
    if (!way.robot.empty()) properties["robot"] = way.robot;
    std::vector<Eigen::Vector3d> line;
    for (const TimedPose& pose : way.poses) line.push_back(point_of(pose.pose));
    features.push_back(line_feature(globe, line, std::move(properties)));
  }
  return collection(features);
}

std::string geojson_text(const MapResult& result, const MapOrigin& origin) {
  const Globe globe(origin);
  std::vector<Json> features;
  for (const LandmarkEstimate& l : result.landmarks) {
    if (!l.position.allFinite()) continue;
    Json properties = {{"id", l.id},
                       {"sightings", l.sightings},
                       {"sigma_m", std::sqrt(l.covariance.trace() / (l.is_3d ? 3 : 2))}};
    add_size(l.size, properties);
    if (l.class_index) {
      properties["class"] = result.class_names[static_cast<std::size_t>(*l.class_index)];
    }
    features.push_back(feature("Point", globe(l.position), std::move(properties)));
  }
  for (const DrawnPath& path : drawn_paths(result)) {
    if (path.points.size() < 2) continue;
    features.push_back(line_feature(globe, path.points, {{"path", path.name}}));
  }
  for (const FixEstimate& fix : result.fixes) {
    if (result.datum) features.push_back(fix_feature(globe, fix));
  }
  return collection(features);
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
