// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, the hybrid mapping authors

#include "mrpt_plugins/session/scan_places.h"

#include <cmath>
#include <optional>
#include <utility>

#include "libhybrid/clouds/cloud_join.h"
#include "libhybrid/core/evenly_chosen.h"
#include "libhybrid/core/key_letters.h"
#include "libhybrid/geometry/isometry.h"
#include "libhybrid/online/place_chain.h"
#include "libhybrid/scans/scan_join.h"
#include "mrpt_plugins/bridge/pose_conversions.h"
#include "mrpt_plugins/bridge/poses.h"
#include "mrpt_plugins/mapping/cloud_follower.h"
#include "mrpt_plugins/mapping/scan_follower.h"

namespace hybrid {
namespace {

/// Standard deviations of a local map whose covariance is not known any more [m], [rad].
constexpr double kUnknownPlace = 0.1;
constexpr double kUnknownTurn = 0.02;
/// Points of a local cloud that are kept in a map.
constexpr std::size_t kMostCloudPoints = 500000;

}  // namespace

bool has_planar_scans(const MapRecord& map) {
  return !map.local_maps.empty() && !map.is_3d;
}

bool has_clouds(const MapRecord& map) {
  return !map.local_clouds.empty() && map.is_3d;
}

Eigen::Matrix3d planar_covariance(const Eigen::MatrixXd& covariance) {
  if (covariance.rows() == 3) return covariance;
  if (covariance.rows() == 6) return planar_part(covariance);
  return Eigen::Vector3d(kUnknownPlace, kUnknownPlace, kUnknownTurn)
      .cwiseAbs2()
      .asDiagonal()
      .toDenseMatrix();
}

Matrix6d spatial_covariance(const Eigen::MatrixXd& covariance) {
  if (covariance.rows() == SE3::kDim) return covariance;
  return isotropic_covariance(kUnknownPlace, kUnknownTurn);
}

void adopt_places(const Plugins& plugins, const MapRecord& map,
                  const std::vector<RobotSettings>& robots) {
  std::vector<StoredScans> scans;
  std::vector<StoredCloud> clouds;
  if (has_planar_scans(map)) scans = stored_scans(map);
  if (has_clouds(map)) clouds = stored_clouds(map);
  for (const auto& plugin : plugins) {
    auto* by_scans = dynamic_cast<ScanFollower*>(plugin.get());
    auto* by_clouds = dynamic_cast<CloudFollower*>(plugin.get());
    for (std::size_t i = 0; i < robots.size(); ++i) {
      const std::optional<KnownStart>& start = robots[i].options.motion.start;
      if (!start) continue;
      if (by_scans != nullptr && !scans.empty()) {
        by_scans->adopt_scans(i, scans,
                              {to_se2(start->T_map_robot), planar_covariance(start->covariance)});
      }
      if (by_clouds != nullptr && !clouds.empty()) {
        by_clouds->adopt_clouds(
            i, clouds, {to_se3(start->T_map_robot), spatial_covariance(start->covariance)});
      }
    }
  }
}

namespace {

MapLocalMap local_map_of(const LocalScans& scans, const SE2& anchor,
                         const Eigen::MatrixXd& covariance) {
  MapLocalMap local;
  local.pose << anchor.x(), anchor.y(), anchor.angle();
  local.covariance = planar_covariance(covariance);
  for (const SurfacePoint& point : scans.points) {
    local.surfaces.push_back({point.position, std::nullopt});
    if (!point.has_normal()) continue;
    local.surfaces.back().direction = std::atan2(point.normal.y(), point.normal.x());
  }
  return local;
}

MapLocalCloud local_cloud_of(const LocalView& view, const SE3& anchor,
                             const Eigen::MatrixXd& covariance) {
  MapLocalCloud local;
  local.T_map_anchor = {anchor, spatial_covariance(covariance)};
  local.spacing = view.spacing;
  for (const CloudPoint& point : evenly_chosen(view.points, kMostCloudPoints)) {
    local.points.push_back({point.position, point.normal});
  }
  return local;
}

/// The chain of the places that a session knows and sees.
template <class Pose>
PlaceChain<Pose> chain_of(const Backend& backend, std::size_t known_places) {
  PlaceChain<Pose> chain(
      backend.values(), [&](Key key) { return backend.holds(key); },
      [&](const std::vector<Key>& keys, const Eigen::MatrixXd& J) {
        return backend.joint_covariance(keys, J);
      });
  for (std::size_t i = 0; i < known_places; ++i) chain.add(place_key(i));
  return chain;
}

}  // namespace

SeenPlaces seen_places(const Plugins& plugins, const MapResult& result, const Mapper& mapper,
                       std::size_t known_places) {
  SeenPlaces out;
  std::vector<Eigen::MatrixXd> covariances;
  const auto anchor_at = [&](std::size_t keyframe) {
    if (covariances.empty()) covariances = mapper.pose_covariances();
    return to_isometry(result.trajectory[keyframe].pose);
  };
  auto planar = chain_of<SE2>(mapper.backend(), result.is_3d ? 0 : known_places);
  auto spatial = chain_of<SE3>(mapper.backend(), result.is_3d ? known_places : 0);
  for (const auto& plugin : plugins) {
    if (const auto* follower = dynamic_cast<const ScanFollower*>(plugin.get())) {
      for (const LocalScans& scans : follower->local_scans()) {
        if (scans.points.empty()) continue;
        const SE2 anchor = to_se2(anchor_at(scans.anchor));
        out.local_maps.push_back(local_map_of(scans, anchor, covariances[scans.anchor]));
        if (result.is_3d) continue;
        out.local_maps.back().parent = planar.next(Key(key_letter::kPose, scans.anchor));
      }
    }
    if (const auto* follower = dynamic_cast<const CloudFollower*>(plugin.get())) {
      for (const LocalView& view : follower->local_views()) {
        if (view.points.empty() || !result.is_3d) continue;
        const SE3 anchor = to_se3(anchor_at(view.anchor));
        out.local_clouds.push_back(local_cloud_of(view, anchor, covariances[view.anchor]));
        out.local_clouds.back().T_map_anchor.parent =
            spatial.next(Key(key_letter::kPose, view.anchor));
      }
    }
  }
  return out;
}

}  // namespace hybrid
