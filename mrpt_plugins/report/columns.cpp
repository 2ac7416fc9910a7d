// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, the hybrid mapping authors

#include "mrpt_plugins/report/columns.h"

#include <cmath>

#include "mrpt_plugins/bridge/pose_conversions.h"

namespace hybrid {
namespace {

using Json = nlohmann::ordered_json;

}  // namespace

Json decimals(double value, int places) {
  if (!std::isfinite(value)) return nullptr;
  const double scale = std::pow(10.0, places);
  return std::round(value * scale) / scale;
}

Json digits(double value) {
  if (!std::isfinite(value)) return nullptr;
  if (value == 0) return 0;
  const int places = 3 - static_cast<int>(std::floor(std::log10(std::abs(value))));
  return places >= 0 ? decimals(value, std::min(places, 15)) : Json(std::round(value));
}

Json decimals(const std::vector<double>& values, int places) {
  Json out = Json::array();
  for (const double value : values) out.push_back(decimals(value, places));
  return out;
}

Json digits(const std::vector<double>& values) {
  Json out = Json::array();
  for (const double value : values) out.push_back(digits(value));
  return out;
}

Json empty_columns(std::initializer_list<const char*> names) {
  Json out = Json::object();
  for (const char* name : names) out[name] = Json::array();
  return out;
}

Json coordinates(const std::vector<Eigen::Vector3d>& points, bool is_3d) {
  Json out = is_3d ? empty_columns({"x", "y", "z"}) : empty_columns({"x", "y"});
  for (const Eigen::Vector3d& p : points) {
    out["x"].push_back(decimals(p.x()));
    out["y"].push_back(decimals(p.y()));
    if (is_3d) out["z"].push_back(decimals(p.z()));
  }
  return out;
}

Json pose_columns(const Trajectory& trajectory, bool is_3d) {
  std::vector<Eigen::Vector3d> points;
  for (const TimedPose& pose : trajectory) points.push_back(point_of(pose.pose));
  Json out = coordinates(points, is_3d);
  for (const TimedPose& pose : trajectory) {
    out["t"].push_back(decimals(pose.time - trajectory.front().time, 3));
    out["yaw"].push_back(decimals(pose.pose.yaw()));
    if (!is_3d) continue;
    out["pitch"].push_back(decimals(pose.pose.pitch()));
    out["roll"].push_back(decimals(pose.pose.roll()));
  }
  return out;
}

Json steps_of(const std::vector<double>& values, double origin, double unit) {
  Json out = Json::array();
  long before = 0;
  for (const double value : values) {
    const long now = std::lround((value - origin) / unit);
    out.push_back(now - before);
    before = now;
  }
  return out;
}

}  // namespace hybrid
