// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, the hybrid mapping authors

#include "mrpt_plugins/rawlog/detail/cloud_record.h"

#include <fmt/format.h>
#include <mrpt/maps/CSimplePointsMap.h>
#include <mrpt/obs/CObservation3DRangeScan.h>
#include <mrpt/obs/CObservationVelodyneScan.h>

#include <vector>

#include "libhybrid/core/error.h"
#include "mrpt_plugins/mrpt_version.h"
#include "mrpt_plugins/rawlog/detail/convert_object.h"
#include "mrpt_plugins/rawlog/observation_record.h"

namespace hybrid {
namespace {

using mrpt::maps::CSimplePointsMap;
using mrpt::obs::CObservation;
using mrpt::obs::CObservation3DRangeScan;
using mrpt::obs::CObservationPointCloud;
using mrpt::obs::CObservationVelodyneScan;

constexpr std::size_t kMostPoints = 10'000'000;

bool is_kept_beside(const CObservation& observation) {
  if (const auto* cloud = dynamic_cast<const CObservationPointCloud*>(&observation)) {
    return cloud->isExternallyStored() || !cloud->pointcloud;
  }
  const auto* depth = dynamic_cast<const CObservation3DRangeScan*>(&observation);
  return depth != nullptr &&
         (depth->rangeImage_isExternallyStored() || depth->points3D_isExternallyStored());
}

/// All points, in the frame of the sensor.
std::vector<mrpt::math::TPoint3Df> points_seen(const CObservation& observation) {
  if (const auto* cloud = dynamic_cast<const CObservationPointCloud*>(&observation)) {
    return points_of(*cloud->pointcloud);
  }
  CSimplePointsMap map;
  if (const auto* depth = dynamic_cast<const CObservation3DRangeScan*>(&observation)) {
    if (!depth->hasRangeImage) {
      map.setAllPoints(depth->points3D_x, depth->points3D_y, depth->points3D_z);
      return points_of(map);
    }
    mrpt::obs::T3DPointsProjectionParams options;
    options.takeIntoAccountSensorPoseOnRobot = false;
    CObservation3DRangeScan copy = *depth;  // MRPT keeps tables in it
    copy.unprojectInto(map, options);
    return points_of(map);
  }
  map.insertionOptions.minDistBetweenLaserPoints = 0;
  keep_all_points(map.insertionOptions);
  mrpt::poses::CPose3D sensor;
  observation.getSensorPose(sensor);
  const mrpt::poses::CPose3D T_sensor_robot = mrpt::poses::CPose3D() - sensor;
  map.insertObservation(observation, T_sensor_robot);
  return points_of(map);
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
  const bool beside = is_kept_beside(observation);
  out.put_flag(beside);
  if (beside) return;
  const std::vector<mrpt::math::TPoint3Df> points = points_seen(observation);
  if (points.size() > kMostPoints)
    throw Error(fmt::format("{} points in one cloud", points.size()));
  write_points(out, points);
}

void read_cloud(ByteReader& in, CObservationPointCloud& cloud) {
  cloud.sensorPose = read_pose_3d(in);
  if (in.flag()) return;
  const auto map = CSimplePointsMap::Create();
  const std::vector<mrpt::math::TPoint3Df> points = read_points(in);
  map->reserve(points.size());
  for (const mrpt::math::TPoint3Df& p : points) map->insertPointFast(p.x, p.y, p.z);
  cloud.pointcloud = map;
}

}  // namespace hybrid
