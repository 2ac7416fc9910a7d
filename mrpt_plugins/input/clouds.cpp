// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, the hybrid mapping authors

#include "mrpt_plugins/input/clouds.h"

#include <mrpt/maps/CPointsMap.h>

#include <cmath>

#include "mrpt_plugins/bridge/pose_conversions.h"
#include "mrpt_plugins/bridge/poses.h"
#include "mrpt_plugins/mrpt_version.h"
#include "mrpt_plugins/observations/logged_cloud.h"

namespace hybrid {
namespace {

constexpr double kFarthestSensor = 1000;  // m
constexpr const char* kNoPoints = "cloud dropped: no points";

}  // namespace

bool is_cloud(const mrpt::obs::CObservation& observation) {
  return dynamic_cast<const mrpt::obs::CObservationPointCloud*>(&observation) != nullptr;
}

bool is_empty_cloud(const mrpt::obs::CObservation& observation) {
  const auto* seen = dynamic_cast<const mrpt::obs::CObservationPointCloud*>(&observation);
  if (seen == nullptr || !seen->pointcloud) return false;
  std::vector<float> x, y, z;
  seen->pointcloud->getAllPoints(x, y, z);
  for (std::size_t i = 0; i < x.size(); ++i) {
    if (Eigen::Vector3f(x[i], y[i], z[i]).allFinite()) return false;
  }
  return true;
}

std::optional<PointCloud> cloud_in(const mrpt::obs::CObservation& observation, DropReport& report) {
  const auto* seen = dynamic_cast<const mrpt::obs::CObservationPointCloud*>(&observation);
  if (seen == nullptr) return std::nullopt;
  if (!seen->pointcloud) {
    const auto* logged = dynamic_cast<const LoggedCloud*>(seen);
    const bool is_known = logged != nullptr && !logged->fault.empty();
    ++report[is_known ? logged->fault : "cloud dropped: its points are in a file beside the log"];
    return std::nullopt;
  }
  if (!(seen->sensorPose.norm() <= kFarthestSensor) || !is_rotation(seen->sensorPose)) {
    ++report["cloud dropped: sensor pose absurd"];
    return std::nullopt;
  }
  if (seen->pointcloud->empty()) {
    ++report[kNoPoints];
    return std::nullopt;
  }
  const Eigen::Isometry3f T = to_isometry(seen->sensorPose).cast<float>();
  PointCloud out;
  out.stamp = seconds_of(seen->timestamp);
  out.sensor = T.translation();
  std::vector<float> x, y, z;
  seen->pointcloud->getAllPoints(x, y, z);
  std::vector<float> times;
  if (const auto* timed = dynamic_cast<const LoggedCloud*>(seen)) times = timed->times;
  if (!times.empty() && times.size() != x.size()) {
    ++report["times of a cloud dropped: they are not as many as its points"];
    times.clear();
  }
  out.points.reserve(x.size());
  for (std::size_t i = 0; i < x.size(); ++i) {
    const Eigen::Vector3f p(x[i], y[i], z[i]);
    if (!p.allFinite()) continue;
    out.points.push_back(T * p);
    if (!times.empty()) out.times.push_back(times[i]);
  }
  if (out.points.empty()) {
    ++report[kNoPoints];
    return std::nullopt;
  }
  return out;
}

}  // namespace hybrid
