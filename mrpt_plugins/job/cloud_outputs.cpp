// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, the hybrid mapping authors

#include "mrpt_plugins/job/detail/cloud_outputs.h"

#include <utility>

#include "libhybrid/clouds/cloud_join.h"
#include "libhybrid/geometry/isometry.h"
#include "mrpt_plugins/bridge/pose_conversions.h"
#include "mrpt_plugins/output/cloud_writer.h"
#include "mrpt_plugins/output/scan_map.h"

namespace hybrid {
namespace {

/// Clouds of a known map, and those of the run, where it has put them.
std::vector<StoredCloud> all_clouds(const MapRecord& known, std::vector<LocalView> views,
                                    const MapResult& result) {
  std::vector<StoredCloud> out = stored_clouds(known);
  for (LocalView& view : views) {
    const SE3 T = to_se3(to_isometry(result.trajectory[view.anchor].pose));
    out.push_back({{T, Matrix6::Identity()}, std::move(view.points), view.spacing});
  }
  return out;
}

}  // namespace

void add_clouds(const std::vector<std::shared_ptr<MappingPlugin>>& plugins, const MapRecord& known,
                MapResult& result) {
  const CloudFollower* follower = cloud_follower_of(plugins);
  if (follower == nullptr) return;
  for (const MeasuredClosure<SE3>& closure : follower->cloud_closures()) {
    result.scan_closures.push_back(closure);
  }
  auto cloud = std::make_shared<const std::vector<CloudPoint>>(
      surfaces_of(all_clouds(known, follower->local_views(), result)));
  if (cloud->empty()) return;
  GridMap grid = cloud_grid(*cloud);
  if (!result.grid && !grid.empty()) result.grid = std::make_shared<const GridMap>(std::move(grid));
  result.cloud = std::move(cloud);
}

std::vector<LocalView> views_of(const std::vector<std::shared_ptr<MappingPlugin>>& plugins) {
  const CloudFollower* follower = cloud_follower_of(plugins);
  return follower == nullptr ? std::vector<LocalView>() : follower->local_views();
}

void write_clouds(const OutputDirectory& out,
                  const std::vector<std::shared_ptr<MappingPlugin>>& plugins,
                  const MapResult& result, const Mapper& mapper) {
  const CloudFollower* follower = cloud_follower_of(plugins);
  if (follower == nullptr) return;
  const std::vector<MeasuredClosure<SE3>> closures = follower->cloud_closures();
  if (!closures.empty()) out.write("cloud_loops.csv", cloud_closures_csv(closures));
  if (!result.cloud) return;
  out.write("cloud.ply", cloud_ply(*result.cloud));
  out.write("cloud.pcd", cloud_pcd(*result.cloud));
  write_simple_map(out, "map.simplemap", follower->local_views(), result.trajectory,
                   mapper.pose_covariances());
}

}  // namespace hybrid
