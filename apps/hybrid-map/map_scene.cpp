// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, the hybrid mapping authors

#include "apps/hybrid-map/map_scene.h"

#include <fmt/format.h>

#include <Eigen/Eigenvalues>
#include <algorithm>
#include <cmath>
#include <limits>
#include <map>
#include <nlohmann/json.hpp>
#include <utility>
#include <vector>

#include "libhybrid/discrete/probabilities.h"
#include "mrpt_plugins/bridge/pose_conversions.h"
#include "mrpt_plugins/drawing/style.h"
#include "mrpt_plugins/map_file/export_map.h"

namespace hybrid {
namespace {

using Json = nlohmann::ordered_json;

/// Records of MCAP (mcap.dev/spec), of one topic.
class McapWriter {
 public:
  McapWriter(const std::string& topic, const std::string& schema_name, const Json& schema) {
    bytes_ = kMagic;
    record(kHeader, text("") + text("hybrid"));
    record(kSchema,
           number<std::uint16_t>(1) + text(schema_name) + text("jsonschema") + text(schema.dump()));
    record(kChannel, number<std::uint16_t>(1) + number<std::uint16_t>(1) + text(topic) +
                         text("json") + number<std::uint32_t>(0));
  }

  void write(double seconds, const Json& message) {
    const auto time = static_cast<std::uint64_t>(std::llround(std::max(0.0, seconds) * 1e9));
    record(kMessage, number<std::uint16_t>(1) + number(count_++) + number(time) + number(time) +
                         message.dump(-1, ' ', false, Json::error_handler_t::replace));
  }

  std::string finish() {
    record(kDataEnd, number<std::uint32_t>(0));
    record(kFooter, number<std::uint64_t>(0) + number<std::uint64_t>(0) + number<std::uint32_t>(0));
    return std::move(bytes_ += kMagic);
  }

 private:
  static constexpr const char* kMagic = "\x89MCAP0\r\n";
  enum Kind : char {
    kHeader = 1,
    kFooter = 2,
    kSchema = 3,
    kChannel = 4,
    kMessage = 5,
    kDataEnd = 15
  };

  /// The lowest byte first.
  template <class T>
  static std::string number(T value) {
    std::string out;
    for (std::size_t i = 0; i < sizeof(T); ++i)
      out += static_cast<char>((value >> (8 * i)) & 0xFFU);
    return out;
  }
  static std::string text(const std::string& value) {
    return number(static_cast<std::uint32_t>(value.size())) + value;
  }
  void record(Kind kind, const std::string& content) {
    bytes_ +=
        static_cast<char>(kind) + number(static_cast<std::uint64_t>(content.size())) + content;
  }

  std::string bytes_;
  std::uint32_t count_ = 0;
};

Json record_of(const Json& fields) {
  return {{"type", "object"}, {"properties", fields}};
}

Json array_of(const Json& items) {
  return {{"type", "array"}, {"items", items}};
}

/// What the messages hold of foxglove.SceneUpdate.
Json scene_schema() {
  const Json number = {{"type", "number"}};
  const Json integer = {{"type", "integer"}};
  const Json text = {{"type", "string"}};
  const Json yes_no = {{"type", "boolean"}};
  const Json time = record_of({{"sec", integer}, {"nsec", integer}});
  const Json point = record_of({{"x", number}, {"y", number}, {"z", number}});
  const Json turn = record_of({{"x", number}, {"y", number}, {"z", number}, {"w", number}});
  const Json color = record_of({{"r", number}, {"g", number}, {"b", number}, {"a", number}});
  const Json pose = record_of({{"position", point}, {"orientation", turn}});
  const Json nothing = array_of(record_of(Json::object()));
  const Json arrow = record_of({{"pose", pose},
                                {"shaft_length", number},
                                {"shaft_diameter", number},
                                {"head_length", number},
                                {"head_diameter", number},
                                {"color", color}});
  const Json line = record_of({{"type", integer},
                               {"pose", pose},
                               {"thickness", number},
                               {"scale_invariant", yes_no},
                               {"points", array_of(point)},
                               {"color", color},
                               {"colors", array_of(color)},
                               {"indices", array_of(integer)}});
  const Json label = record_of({{"pose", pose},
                                {"billboard", yes_no},
                                {"font_size", number},
                                {"scale_invariant", yes_no},
                                {"color", color},
                                {"text", text}});
  const Json entity = record_of(
      {{"timestamp", time},
       {"frame_id", text},
       {"id", text},
       {"lifetime", time},
       {"frame_locked", yes_no},
       {"metadata", array_of(record_of({{"key", text}, {"value", text}}))},
       {"arrows", array_of(arrow)},
       {"spheres", array_of(record_of({{"pose", pose}, {"size", point}, {"color", color}}))},
       {"lines", array_of(line)},
       {"texts", array_of(label)},
       {"cubes", nothing},
       {"cylinders", nothing},
       {"triangles", nothing},
       {"models", nothing}});
  const Json deletion = record_of({{"timestamp", time}, {"type", integer}, {"id", text}});
  return record_of({{"deletions", array_of(deletion)}, {"entities", array_of(entity)}});
}

Json point_json(const Eigen::Vector3d& p) {
  return {{"x", p.x()}, {"y", p.y()}, {"z", p.z()}};
}

Json pose_json(const Eigen::Vector3d& position,
               const Eigen::Quaterniond& turn = Eigen::Quaterniond::Identity()) {
  return {{"position", point_json(position)},
          {"orientation", {{"x", turn.x()}, {"y", turn.y()}, {"z", turn.z()}, {"w", turn.w()}}}};
}

Json color_json(Color color, double opacity = 1) {
  constexpr double kFull = 255;
  return {{"r", color.red / kFull},
          {"g", color.green / kFull},
          {"b", color.blue / kFull},
          {"a", opacity}};
}

Json entity_json(double seconds, const std::string& id) {
  const double whole = std::floor(std::max(0.0, seconds));
  const auto rest = static_cast<long>(std::lround((std::max(0.0, seconds) - whole) * 1e9));
  Json out = {{"timestamp",
               {{"sec", static_cast<std::int64_t>(whole)}, {"nsec", std::min(rest, 999'999'999L)}}},
              {"frame_id", "map"},
              {"id", id},
              {"lifetime", {{"sec", 0}, {"nsec", 0}}},
              {"frame_locked", false}};
  for (const char* list : {"metadata", "arrows", "cubes", "spheres", "cylinders", "lines",
                           "triangles", "texts", "models"}) {
    out[list] = Json::array();
  }
  return out;
}

/// The ellipsoid of 3 standard deviations; in the plane it is flat.
Json ellipsoid_json(const MapLandmark& landmark, Color color) {
  constexpr double kAcross = 6, kThinnest = 0.01;
  const Eigen::SelfAdjointEigenSolver<Eigen::Matrix3d> axes(landmark.covariance);
  Eigen::Matrix3d turn = axes.eigenvectors();
  if (turn.determinant() < 0) turn.col(0) *= -1;
  const Eigen::Vector3d size =
      (kAcross * axes.eigenvalues().cwiseMax(0).cwiseSqrt()).cwiseMax(kThinnest);
  return {{"pose", pose_json(landmark.position, Eigen::Quaterniond(turn))},
          {"size", point_json(size)},
          {"color", color_json(color, 0.3)}};
}

Json landmark_entity(const MapRecord& map, const MapLandmark& l, double seconds) {
  constexpr double kSize = 0.3;  // of the sphere [m]
  Json out = entity_json(seconds, fmt::format("landmark/{}", l.id));
  const int best = most_probable(l.class_probabilities);
  const auto index = static_cast<std::size_t>(std::max(0, best));
  const Color color = best < 0 ? palette::kUnclassed : series_color(index);
  const std::string name = best < 0 ? "" : map.class_names[index];
  const auto tell = [&](const char* key, const std::string& value) {
    out["metadata"].push_back({{"key", key}, {"value", value}});
  };
  if (best >= 0) {
    tell("class", name);
    tell("probability", fmt::format("{:.3g}", l.class_probabilities[index]));
  }
  tell("sightings", std::to_string(l.sightings));
  tell("session", std::to_string(l.session));
  tell("things", std::to_string(l.size.things));
  if (l.size.extent > 0) tell("extent_m", fmt::format("{:.3g}", l.size.extent));
  std::string label = std::to_string(l.id);
  if (best >= 0) label += " " + name;
  if (l.size.things > 1) label += fmt::format(" \u00d7{}", l.size.things);
  out["spheres"] = Json::array({{{"pose", pose_json(l.position)},
                                 {"size", point_json(Eigen::Vector3d::Constant(kSize))},
                                 {"color", color_json(color)}},
                                ellipsoid_json(l, color)});
  out["texts"] = Json::array({{{"pose", pose_json(l.position + kSize * Eigen::Vector3d::UnitZ())},
                               {"billboard", true},
                               {"font_size", 12},
                               {"scale_invariant", true},
                               {"color", color_json(palette::kTruth)},
                               {"text", std::move(label)}}});
  return out;
}

/// The session and, where it has a name, the robot.
std::string name_of(const MapWay& way) {
  return way.robot.empty() ? std::to_string(way.session)
                           : fmt::format("{}/{}", way.session, way.robot);
}

Json path_entity(const MapWay& way, double seconds) {
  Json out = entity_json(seconds, "path/" + name_of(way));
  Json points = Json::array();
  for (const TimedPose& p : way.poses) {
    points.push_back(point_json({p.pose.x(), p.pose.y(), p.pose.z()}));
  }
  out["lines"] = Json::array({{{"type", 0},
                               {"pose", pose_json(Eigen::Vector3d::Zero())},
                               {"thickness", 2},
                               {"scale_invariant", true},
                               {"points", std::move(points)},
                               {"color", color_json(palette::kEstimate)},
                               {"colors", Json::array()},
                               {"indices", Json::array()}}});
  return out;
}

Json robot_entity(const std::string& name, const TimedPose& at) {
  Json out = entity_json(at.time, "robot/" + name);
  const Eigen::Isometry3d T = to_isometry(at.pose);
  out["arrows"] =
      Json::array({{{"pose", pose_json(T.translation(), Eigen::Quaterniond(T.linear()))},
                    {"shaft_length", 0.6},
                    {"shaft_diameter", 0.15},
                    {"head_length", 0.3},
                    {"head_diameter", 0.3},
                    {"color", color_json(palette::kInk)}}});
  return out;
}

Json update_of(Json entities) {
  return {{"deletions", Json::array()}, {"entities", std::move(entities)}};
}

}  // namespace

std::string mcap_of(const MapRecord& map) {
  const std::vector<MapWay> ways = ways_of(map);
  std::multimap<double, std::pair<std::string, const TimedPose*>> moments;
  for (const MapWay& way : ways) {
    for (const TimedPose& at : way.poses) moments.insert({at.time, {name_of(way), &at}});
  }
  const double start = moments.empty() ? 0 : moments.begin()->first;
  Json entities = Json::array();
  for (const MapLandmark& l : map.landmarks) {
    if (exists(l)) entities.push_back(landmark_entity(map, l, start));
  }
  for (const MapWay& way : ways) {
    if (!way.poses.empty()) entities.push_back(path_entity(way, start));
  }
  McapWriter out("/hybrid/map", "foxglove.SceneUpdate", scene_schema());
  out.write(start, update_of(std::move(entities)));
  for (const auto& [time, robot] : moments) {
    out.write(time, update_of(Json::array({robot_entity(robot.first, *robot.second)})));
  }
  return out.finish();
}

}  // namespace hybrid
