// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, the hybrid mapping authors

#include "mrpt_plugins/session/detail/scan_places.h"

#include <cmath>
#include <optional>
#include <utility>

#include "libhybrid/geometry/isometry.h"
#include "libhybrid/scans/scan_join.h"
#include "mrpt_plugins/bridge/pose_conversions.h"
#include "mrpt_plugins/bridge/poses.h"
#include "mrpt_plugins/mapping/scan_follower.h"

namespace hybrid {
namespace {

/// Standard deviations of a local map whose covariance is not known any more [m], [rad].
constexpr double kUnknownPlace = 0.1;
constexpr double kUnknownTurn = 0.02;

}  // namespace

bool has_planar_scans(const MapRecord& map) {
  return !map.local_maps.empty() && !map.is_3d;
}

Eigen::Matrix3d planar_covariance(const Eigen::MatrixXd& covariance) {
  if (covariance.rows() == 3) return covariance;
  if (covariance.rows() == 6) return planar_part(covariance);
  return Eigen::Vector3d(kUnknownPlace, kUnknownPlace, kUnknownTurn)
      .cwiseAbs2()
      .asDiagonal()
      .toDenseMatrix();
}

void adopt_scans(const Plugins& plugins, const MapRecord& map,
                 const std::vector<RobotSettings>& robots) {
  if (!has_planar_scans(map)) return;
  const std::vector<StoredScans> stored = stored_scans(map);
  for (const auto& plugin : plugins) {
    auto* follower = dynamic_cast<ScanFollower*>(plugin.get());
    for (std::size_t i = 0; follower != nullptr && i < robots.size(); ++i) {
      const std::optional<KnownStart>& start = robots[i].options.motion.start;
      if (!start) continue;
      follower->adopt_scans(i, stored,
                            {to_se2(start->T_map_robot), planar_covariance(start->covariance)});
    }
  }
}

std::vector<MapLocalMap> local_maps(const Plugins& plugins, const MapResult& result,
                                    const Mapper& mapper) {
  std::vector<MapLocalMap> out;
  std::vector<Eigen::MatrixXd> covariances;
  for (const auto& plugin : plugins) {
    const auto* follower = dynamic_cast<const ScanFollower*>(plugin.get());
    if (follower == nullptr) continue;
    if (covariances.empty()) covariances = mapper.pose_covariances();
    for (const LocalScans& scans : follower->local_scans()) {
      const SE2 anchor = to_se2(to_isometry(result.trajectory[scans.anchor].pose));
      MapLocalMap local;
      local.pose << anchor.x(), anchor.y(), anchor.angle();
      local.covariance = planar_covariance(covariances[scans.anchor]);
      for (const SurfacePoint& point : scans.points) {
        local.surfaces.push_back({point.position, std::nullopt});
        if (!point.has_normal()) continue;
        local.surfaces.back().direction = std::atan2(point.normal.y(), point.normal.x());
      }
      if (!local.surfaces.empty()) out.push_back(std::move(local));
    }
  }
  return out;
}

}  // namespace hybrid
