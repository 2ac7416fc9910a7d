// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, the hybrid mapping authors

#include "mrpt_plugins/rawlog/detail/cloud_record.h"

#include <fmt/format.h>
#include <mrpt/maps/CSimplePointsMap.h>
#include <mrpt/obs/CObservation3DRangeScan.h>
#include <mrpt/obs/CObservationVelodyneScan.h>

#include <algorithm>
#include <chrono>
#include <cstdint>
#include <limits>
#include <optional>
#include <string>
#include <vector>

#include "libhybrid/core/error.h"
#include "mrpt_plugins/rawlog/detail/convert_object.h"

namespace hybrid {
namespace {

using mrpt::maps::CSimplePointsMap;
using mrpt::math::TPoint3Df;
using mrpt::obs::CObservation;
using mrpt::obs::CObservation3DRangeScan;
using mrpt::obs::CObservationPointCloud;
using mrpt::obs::CObservationVelodyneScan;

constexpr std::size_t kMostPoints = 10'000'000;

/// MRPT has no other way to tell it.
CloudForm form_of(const CObservationPointCloud& cloud) {
  struct Form : CObservationPointCloud {
    static std::uint8_t of(const CObservationPointCloud& cloud) {
      return static_cast<std::uint8_t>(cloud.*(&Form::m_externally_stored));
    }
  };
  const std::uint8_t form = Form::of(cloud);
  return form > static_cast<std::uint8_t>(CloudForm::kText) ? CloudForm::kUnknown
                                                            : static_cast<CloudForm>(form);
}

/// The file that has the points of a cloud; without a name where they are nowhere.
struct FileBeside {
  std::string name;
  CloudForm form = CloudForm::kNone;
};

/// Nothing where the log has the points.
std::optional<FileBeside> file_beside(const CObservation& observation) {
  if (const auto* cloud = dynamic_cast<const CObservationPointCloud*>(&observation)) {
    if (cloud->isExternallyStored()) {
      return FileBeside{cloud->getExternalStorageFile(), form_of(*cloud)};
    }
    return cloud->pointcloud ? std::nullopt : std::optional(FileBeside());
  }
  const auto* depth = dynamic_cast<const CObservation3DRangeScan*>(&observation);
  if (depth == nullptr) return std::nullopt;
  if (depth->hasRangeImage) {
    if (!depth->rangeImage_isExternallyStored()) return std::nullopt;
    return FileBeside{depth->rangeImage_getExternalStorageFile(""), CloudForm::kRanges};
  }
  if (!depth->points3D_isExternallyStored()) return std::nullopt;
  return FileBeside{depth->points3D_getExternalStorageFile(), CloudForm::kCoordinates};
}

void write_camera(ByteWriter& out, const CObservation3DRangeScan& depth) {
  const auto& camera = depth.cameraParams;
  put_all<double, double, double, double>(out, camera.fx(), camera.fy(), camera.cx(), camera.cy());
  for (const double number : camera.dist) out.put(number);
  out.put(static_cast<double>(depth.rangeUnits));
  out.put_flag(depth.range_is_depth);
}

DepthCamera read_camera(ByteReader& in) {
  DepthCamera camera;
  get_all(in, camera.fx, camera.fy, camera.cx, camera.cy);
  for (double& number : camera.distortion) number = in.get<double>();
  camera.unit = in.get<double>();
  camera.is_depth = in.flag();
  return camera;
}

/// In the frame of the sensor; as many times as points, or none, unless the log is damaged.
struct SeenPoints {
  std::vector<TPoint3Df> points;
  std::vector<float> times;
};

/// Relative to the stamp [s]; NaN where MRPT's stamp says that it is none.
float time_after(mrpt::system::TTimeStamp stamp, mrpt::system::TTimeStamp time) {
  if (time == INVALID_TIMESTAMP) return std::numeric_limits<float>::quiet_NaN();
  const auto ticks = [](mrpt::system::TTimeStamp at) {
    return static_cast<std::uint64_t>(at.time_since_epoch().count());
  };
  // Damaged ones may be farther apart than any number is.
  const mrpt::Clock::duration after(static_cast<std::int64_t>(ticks(time) - ticks(stamp)));
  return std::chrono::duration<float>(after).count();
}

SeenPoints swept_points(CObservationVelodyneScan scan) {
  auto& cloud = scan.point_cloud;
  if (cloud.size() == 0) {
    CObservationVelodyneScan::TGeneratePointCloudParameters options;
    options.generatePerPointTimestamp = true;
    scan.generatePointCloud(options);
  }
  if (cloud.y.size() != cloud.size() || cloud.z.size() != cloud.size()) {
    throw Error("the coordinates of a cloud differ in number");
  }
  SeenPoints out;
  for (std::size_t i = 0; i < cloud.size(); ++i) {
    out.points.emplace_back(cloud.x[i], cloud.y[i], cloud.z[i]);
  }
  if (scan.timestamp == INVALID_TIMESTAMP) return out;
  for (const auto time : cloud.timestamp) out.times.push_back(time_after(scan.timestamp, time));
  return out;
}

SeenPoints points_seen(const CObservation& observation) {
  if (const auto* cloud = dynamic_cast<const CObservationPointCloud*>(&observation)) {
    return {points_of(*cloud->pointcloud), {}};
  }
  if (const auto* sweep = dynamic_cast<const CObservationVelodyneScan*>(&observation)) {
    return swept_points(*sweep);
  }
  CSimplePointsMap map;
  const auto& depth = dynamic_cast<const CObservation3DRangeScan&>(observation);
  if (!depth.hasRangeImage) {
    map.setAllPoints(depth.points3D_x, depth.points3D_y, depth.points3D_z);
    return {points_of(map), {}};
  }
  mrpt::obs::T3DPointsProjectionParams options;
  options.takeIntoAccountSensorPoseOnRobot = false;
  CObservation3DRangeScan copy = depth;             // MRPT keeps pixels in it
  copy.sensorPose = {};                             // and tables of each pose,
  copy.points3D_overrideExternalStoredFlag(false);  // and would read what is not here
  copy.unprojectInto(map, options);
  return {points_of(map), {}};
}

}  // namespace

bool is_cloud_of_log(const CObservation& observation) {
  return dynamic_cast<const CObservationPointCloud*>(&observation) != nullptr ||
         dynamic_cast<const CObservation3DRangeScan*>(&observation) != nullptr ||
         dynamic_cast<const CObservationVelodyneScan*>(&observation) != nullptr;
}

void write_cloud(ByteWriter& out, const CObservation& observation) {
  mrpt::poses::CPose3D sensor;
  observation.getSensorPose(sensor);
  write_pose(out, sensor);
  const std::optional<FileBeside> file = file_beside(observation);
  out.put_flag(file.has_value());
  if (file) {
    out.put_text(file->name);
    out.put(static_cast<std::uint8_t>(file->form));
    if (file->form != CloudForm::kRanges) return;
    write_camera(out, dynamic_cast<const CObservation3DRangeScan&>(observation));
    return;
  }
  const SeenPoints seen = points_seen(observation);
  const std::size_t most = std::max(seen.points.size(), seen.times.size());
  if (most > kMostPoints) throw Error(fmt::format("{} points in one cloud", most));
  write_points(out, seen.points);
  out.put(static_cast<std::uint32_t>(seen.times.size()));
  for (const float time : seen.times) out.put(time);
}

void read_cloud(ByteReader& in, LoggedCloud& cloud) {
  cloud.sensorPose = read_pose_3d(in);
  if (in.flag()) {
    cloud.file = in.text();
    cloud.form = static_cast<CloudForm>(in.get<std::uint8_t>());
    if (cloud.form == CloudForm::kRanges) cloud.camera = read_camera(in);
    return;
  }
  const auto map = CSimplePointsMap::Create();
  const std::vector<TPoint3Df> points = read_points(in);
  map->reserve(points.size());
  for (const TPoint3Df& p : points) map->insertPointFast(p.x, p.y, p.z);
  cloud.pointcloud = map;
  cloud.times.resize(in.count(sizeof(float)));
  for (float& time : cloud.times) time = in.get<float>();
}

}  // namespace hybrid
