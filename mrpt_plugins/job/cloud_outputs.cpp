// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, the hybrid mapping authors

#include "mrpt_plugins/job/detail/cloud_outputs.h"

#include <utility>

#include "libhybrid/clouds/cloud_surfaces.h"
#include "libhybrid/geometry/isometry.h"
#include "mrpt_plugins/bridge/pose_conversions.h"
#include "mrpt_plugins/output/cloud_writer.h"

namespace hybrid {
namespace {

/// All that was seen, in the map: points nearer to each other than a spacing are one.
std::vector<CloudPoint> joined(const std::vector<LocalView>& views, const MapResult& result) {
  double spacing = 0;
  for (const LocalView& view : views) spacing = std::max(spacing, view.spacing);
  if (spacing == 0) return {};
  CloudSurfaces all(spacing);
  for (const LocalView& view : views) {
    const SE3 T = to_se3(to_isometry(result.trajectory[view.anchor].pose));
    all.add(transformed(T, view.points));
  }
  return all.points();
}

}  // namespace

void add_clouds(const std::vector<std::shared_ptr<MappingPlugin>>& plugins, MapResult& result) {
  const CloudFollower* follower = cloud_follower_of(plugins);
  if (follower == nullptr) return;
  for (const MeasuredCloudClosure& closure : follower->cloud_closures()) {
    result.scan_closures.push_back(closure);
  }
  auto cloud =
      std::make_shared<const std::vector<CloudPoint>>(joined(follower->local_views(), result));
  if (cloud->empty()) return;
  GridMap grid = cloud_grid(*cloud);
  if (!result.grid && !grid.empty()) result.grid = std::make_shared<const GridMap>(std::move(grid));
  result.cloud = std::move(cloud);
}

void write_clouds(const OutputDirectory& out,
                  const std::vector<std::shared_ptr<MappingPlugin>>& plugins,
                  const MapResult& result) {
  const CloudFollower* follower = cloud_follower_of(plugins);
  if (follower == nullptr) return;
  const std::vector<MeasuredCloudClosure> closures = follower->cloud_closures();
  if (!closures.empty()) out.write("cloud_loops.csv", cloud_closures_csv(closures));
  if (!result.cloud) return;
  out.write("cloud.ply", cloud_ply(*result.cloud));
  out.write("cloud.pcd", cloud_pcd(*result.cloud));
}

}  // namespace hybrid
