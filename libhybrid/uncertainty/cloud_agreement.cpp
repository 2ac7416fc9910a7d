// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, the hybrid mapping authors

#include <algorithm>
#include <cmath>
#include <optional>
#include <utility>

#include "libhybrid/core/evenly_chosen.h"
#include "libhybrid/uncertainty/detail/look_table.h"

namespace hybrid {
namespace {

constexpr std::size_t kPlaces = 40;        // of each cloud
constexpr std::size_t kMostInMap = 20000;  // surfaces of a map

/// How far a place may be from a sensor that looks at it, in reaches of the sensor.
constexpr double kFarLook = 2;

/// A surface, and the direction that it was seen in, in the map.
struct SurfaceInMap {
  Eigen::Vector3d position, normal, seen;
};

class CloudLooks {
 public:
  CloudLooks(std::vector<PlacedCloud> clouds, double reach, AgreementOptions options)
      : clouds_(std::move(clouds)), farthest_(kFarLook * reach) {
    std::stable_sort(clouds_.begin(), clouds_.end(),
                     [](const auto& a, const auto& b) { return a.time < b.time; });
    options_ = options_for(options, clouds_.back().time - clouds_.front().time);
    table_.emplace(clouds_.front().time, farthest_);
  }

  void look_at_own_places(bool late) {
    for (const PlacedCloud& from : clouds_) {
      std::vector<std::size_t> near;
      std::vector<std::pair<double, int>> times;
      for (std::size_t j = 0; j < clouds_.size(); ++j) {
        if ((from.sensor() - clouds_[j].sensor()).norm() > 2 * farthest_) continue;
        near.push_back(j);
        times.emplace_back(clouds_[j].time, clouds_[j].robot);
      }
      const auto looks = LookChoice(std::move(times), options_).around(from.time, from.robot);
      for (const CloudPoint& point : evenly_chosen(from.view->surfaces(), kPlaces)) {
        SurfaceInMap place = in_map(from.T_map_robot, point);
        place.seen = place.position - from.sensor();
        table_->begin_place(from.time);
        for (const auto& [when, j] : looks) {
          if (late || when != LookTime::kLate) look(place, clouds_[near[j]], when);
        }
      }
    }
  }

  void look_at_map(const std::vector<StoredCloud>& map) {
    std::vector<SurfaceInMap> known;
    const std::size_t each = kMostInMap / std::max<std::size_t>(1, map.size()) + 1;
    for (const StoredCloud& stored : map) {
      for (const CloudPoint& point : evenly_chosen(stored.points, each)) {
        if (point.has_normal()) known.push_back(in_map(stored.T_map_anchor.motion, point));
      }
    }
    for (const PlacedCloud& cloud : clouds_) {
      table_->begin_known_place(cloud.time);
      for (const SurfaceInMap& place : known) look(place, cloud, LookTime::kLate);
    }
  }

  Agreement conclude() {
    Agreement out = table_->conclude();
    out.far_from = options_.far_from;
    return out;
  }

 private:
  /// Surfaces of a map are looked at from their front.
  static SurfaceInMap in_map(const SE3& T, const CloudPoint& point) {
    const Eigen::Vector3d normal = T.rotation() * point.normal.cast<double>();
    return {T * point.position.cast<double>(), normal, -normal};
  }

  void look(const SurfaceInMap& place, const PlacedCloud& to, LookTime when) {
    const Eigen::Vector3d ray = place.position - to.sensor();
    if (ray.norm() > farthest_ || place.normal.dot(ray) > 0) return;  // from behind
    const SE3 T_robot_map = to.T_map_robot.inverse();
    const Eigen::Vector3d at = T_robot_map * place.position;
    const Eigen::Vector3d normal = T_robot_map.rotation() * place.normal;
    const auto found = to.view->finds(at.cast<float>(), normal.cast<float>());
    if (found) table_->add(when, ray.norm(), angle_between(place.seen, ray), *found);
  }

  std::vector<PlacedCloud> clouds_;
  double farthest_;
  AgreementOptions options_;
  std::optional<LookTable> table_;
};

}  // namespace

Agreement agreement_of_clouds(std::vector<PlacedCloud> clouds, double reach,
                              const AgreementOptions& options) {
  if (clouds.empty() || !(reach > 0)) return {};
  CloudLooks looked(std::move(clouds), reach, options);
  looked.look_at_own_places(true);
  return looked.conclude();
}

Agreement agreement_with_map(std::vector<PlacedCloud> clouds, double reach,
                             const std::vector<StoredCloud>& map, const AgreementOptions& options) {
  if (clouds.empty() || !(reach > 0) || map.empty()) return {};
  CloudLooks looked(std::move(clouds), reach, options);
  looked.look_at_own_places(false);
  looked.look_at_map(map);
  return looked.conclude();
}

}  // namespace hybrid
