// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, the hybrid mapping authors

#include "mrpt_plugins/rawlog/detail/clouds_beside.h"

#include <mrpt/maps/CSimplePointsMap.h>

#include "libhybrid/core/error.h"
#include "libhybrid/io/point_formats.h"
#include "mrpt_plugins/bridge/interrupt.h"
#include "mrpt_plugins/bridge/log_files.h"
#include "mrpt_plugins/observations/logged_cloud.h"
#include "mrpt_plugins/rawlog/detail/depth_files.h"
#include "mrpt_plugins/rawlog/object_reader.h"

namespace hybrid {
namespace {

constexpr std::uintmax_t kMostBytes = std::uintmax_t{1} << 30;

/// The first map of points in a file.
PointFile read_map_of_mrpt(const std::string& path) {
  LogRequest request;
  request.points = true;
  ObjectReader reader(path, request);
  while (const auto object = reader.next()) {
    const auto* map = std::get_if<LoggedPoints>(&*object);
    if (map == nullptr) continue;
    PointFile file;
    for (const auto& p : map->points) add_point(file, {p.x, p.y, p.z}, path);
    return file;
  }
  throw Error(reader.message());
}

PointFile read_cloud_file(const std::string& path, const LoggedCloud& cloud) {
  switch (cloud.form) {
    case CloudForm::kKitti:
      return read_kitti(path);
    case CloudForm::kText:
      return read_rows(path);
    case CloudForm::kMrpt:
      return read_map_of_mrpt(path);
    case CloudForm::kCoordinates:
      return read_coordinates(path);
    case CloudForm::kRanges:
      return unprojected(read_ranges(path), cloud.camera);
    default:
      throw Error(path + ": of an unknown form");
  }
}

void read_beside(LoggedCloud& cloud, const std::string& rawlog) try {
  const auto path = named_file(cloud.file, rawlog, kMostBytes);
  if (!path) {
    cloud.fault = "cloud dropped: its file is not in the folder of images beside the log";
    return;
  }
  const auto map = mrpt::maps::CSimplePointsMap::Create();
  for (const Eigen::Vector3d& point : read_cloud_file(path->string(), cloud).points) {
    const Eigen::Vector3f p = point.cast<float>();
    map->insertPointFast(p.x(), p.y(), p.z());
  }
  cloud.pointcloud = map;
} catch (const Interrupted&) {
  throw;
} catch (const Error&) {
  cloud.fault = "cloud dropped: its file beside the log cannot be read";
}

void read_beside(const LoggedObservation& observation, const std::string& rawlog) {
  auto* cloud = dynamic_cast<LoggedCloud*>(observation.content.get());
  if (cloud != nullptr && !cloud->file.empty()) read_beside(*cloud, rawlog);
}

}  // namespace

void read_clouds_beside(LogObject& object, const std::string& rawlog) {
  if (const auto* observation = std::get_if<LoggedObservation>(&object)) {
    read_beside(*observation, rawlog);
  } else if (const auto* frame = std::get_if<LoggedFrame>(&object)) {
    for (const LoggedObservation& seen : frame->observations) read_beside(seen, rawlog);
  }
}

}  // namespace hybrid
