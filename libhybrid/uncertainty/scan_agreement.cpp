// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, the hybrid mapping authors

#include <algorithm>
#include <cmath>
#include <optional>

#include "libhybrid/core/evenly_chosen.h"
#include "libhybrid/geometry/so2.h"
#include "libhybrid/uncertainty/detail/look_table.h"

namespace hybrid {
namespace {

constexpr std::size_t kMostScans = 1000;  // whose returns are looked at again
constexpr std::size_t kMostKnown = 8000;  // surfaces of a map
constexpr std::size_t kRays = 40;         // of each of them
constexpr double kReach = 12;             // [m]; rays spread, and graze what is farther away
constexpr double kShortest = 0.3;         // [m]; the robot itself is nearer
constexpr double kGrazing = 1.2;          // [rad] to the normal of a surface
constexpr double kSame = 0.1;             // [m] to a surface that is the same, two cells of a grid

/// A return and the direction that it was seen in, in the map.
struct SurfacePlace {
  Eigen::Vector2d point;
  double direction = 0;
};

bool is_return(float range) {
  return std::isfinite(range) && range > kShortest;
}

/// Angle of a ray in the frame of the sensor, seen from above.
double angle_of(const PlacedScan& at, double ray) {
  const double angle = at.scan->first_angle + ray * at.scan->angle_step;
  return at.is_upside_down ? -angle : angle;
}

Eigen::Vector2d end_of(const PlacedScan& at, std::size_t ray) {
  const double angle = angle_of(at, static_cast<double>(ray));
  const double range = at.scan->ranges[ray];
  return at.T_map_sensor * Eigen::Vector2d(range * std::cos(angle), range * std::sin(angle));
}

std::vector<SurfacePlace> surfaces_of(const PlacedScan& at) {
  std::vector<std::size_t> rays;
  for (std::size_t i = 0; i < at.scan->ranges.size(); ++i) {
    if (is_return(at.scan->ranges[i]) && at.scan->ranges[i] < kReach) rays.push_back(i);
  }
  std::vector<SurfacePlace> out;
  for (const std::size_t ray : evenly_chosen(rays, kRays)) {
    const Eigen::Vector2d point = end_of(at, ray);
    const Eigen::Vector2d seen = point - at.T_map_sensor.translation();
    out.push_back({point, std::atan2(seen.y(), seen.x())});
  }
  return out;
}

/// Surfaces of a map, each looked at from its front.
std::vector<SurfacePlace> surfaces_of(const std::vector<StoredScans>& map) {
  std::vector<SurfacePlace> all;
  for (const StoredScans& stored : map) {
    for (const SurfacePoint& point : stored.points) {
      if (!point.has_normal() || point.position.norm() > kReach) continue;
      const Eigen::Vector2d seen = stored.T_map_anchor.motion.rotation() * -point.normal;
      all.push_back({stored.T_map_anchor.motion * point.position, std::atan2(seen.y(), seen.x())});
    }
  }
  return evenly_chosen(all, kMostKnown);
}

/// The ray of a scan in a direction of the map, which has neighbours on both sides.
std::optional<std::size_t> ray_towards(const PlacedScan& at, double direction) {
  const LaserScan& scan = *at.scan;
  const double seen = direction - at.T_map_sensor.angle();
  const double angle = at.is_upside_down ? -seen : seen;
  const double turn = 2 * M_PI / std::abs(scan.angle_step);  // rays of a full circle
  double ray = (angle - scan.first_angle) / scan.angle_step;
  ray -= turn * std::floor(ray / turn);
  const double nearest = std::round(ray);
  if (nearest < 1 || nearest + 1 >= static_cast<double>(scan.ranges.size())) return std::nullopt;
  return static_cast<std::size_t>(nearest);
}

/// Whether the rays of a scan towards a place end at it; nothing where they do not come so far.
std::optional<bool> finds(const PlacedScan& at, const SurfacePlace& place, std::size_t ray,
                          double range) {
  const LaserScan& scan = *at.scan;
  const double same = kSame + range * std::abs(scan.angle_step) / 2;
  bool any = false, goes_through = true;
  for (std::size_t i = ray - 1; i <= ray + 1; ++i) {
    if (!is_return(scan.ranges[i])) continue;
    if ((end_of(at, i) - place.point).norm() < same) return true;
    any = true;
    goes_through = goes_through && scan.ranges[i] > range + kSame;
  }
  if (!any || !goes_through) return std::nullopt;
  return false;
}

void look(const SurfacePlace& place, const PlacedScan& at, LookTime when, LookTable& table) {
  const Eigen::Vector2d seen = place.point - at.T_map_sensor.translation();
  const double range = seen.norm();
  if (range > kReach || range < kShortest) return;
  const double direction = std::atan2(seen.y(), seen.x());
  const auto ray = ray_towards(at, direction);
  if (!ray) return;
  const auto found = finds(at, place, *ray, range);
  if (!found) return;
  table.add(when, range, std::abs(wrap_angle(direction - place.direction)), *found);
}

/// Whether a scan sees a surface of a map from its front, and not at a grazing angle.
bool shows_front(const SurfacePlace& place, const PlacedScan& at) {
  const Eigen::Vector2d seen = place.point - at.T_map_sensor.translation();
  return std::abs(wrap_angle(std::atan2(seen.y(), seen.x()) - place.direction)) < kGrazing;
}

bool may_see(const PlacedScan& a, const PlacedScan& b) {
  return (a.T_map_sensor.translation() - b.T_map_sensor.translation()).norm() < 2 * kReach;
}

/// Of scans in order of time.
class LookedAt {
 public:
  LookedAt(std::vector<PlacedScan> scans, const AgreementOptions& options)
      : scans_(std::move(scans)) {
    scans_.erase(std::remove_if(scans_.begin(), scans_.end(),
                                [](const PlacedScan& at) {
                                  return at.scan->ranges.size() < 3 || at.scan->angle_step == 0;
                                }),
                 scans_.end());
    std::stable_sort(scans_.begin(), scans_.end(),
                     [](const auto& a, const auto& b) { return a.time < b.time; });
    if (scans_.empty()) return;
    options_ = options_for(options, scans_.back().time - scans_.front().time);
    table_.emplace(scans_.front().time, kReach);
  }

  void look_at_own_places(bool late) {
    const std::size_t every = (scans_.size() + kMostScans - 1) / kMostScans;
    for (std::size_t i = 0; i < scans_.size(); i += every) {
      std::vector<std::size_t> near;
      std::vector<std::pair<double, int>> times;
      for (std::size_t j = 0; j < scans_.size(); ++j) {
        if (!may_see(scans_[i], scans_[j])) continue;
        near.push_back(j);
        times.emplace_back(scans_[j].time, scans_[j].robot);
      }
      const auto looks =
          LookChoice(std::move(times), options_).around(scans_[i].time, scans_[i].robot);
      for (const SurfacePlace& place : surfaces_of(scans_[i])) {
        table_->begin_place(scans_[i].time);
        for (const auto& [when, j] : looks) {
          if (late || when != LookTime::kLate) look(place, scans_[near[j]], when, *table_);
        }
      }
    }
  }

  void look_at_map(const std::vector<StoredScans>& map) {
    const std::vector<SurfacePlace> known = surfaces_of(map);
    const std::size_t every = (scans_.size() + kMostScans - 1) / kMostScans;
    for (std::size_t i = 0; i < scans_.size(); i += every) {
      table_->begin_known_place(scans_[i].time);
      for (const SurfacePlace& place : known) {
        if (shows_front(place, scans_[i])) look(place, scans_[i], LookTime::kLate, *table_);
      }
    }
  }

  Agreement conclude() {
    if (!table_) return {};
    Agreement out = table_->conclude();
    out.far_from = options_.far_from;
    return out;
  }

 private:
  std::vector<PlacedScan> scans_;
  AgreementOptions options_;
  std::optional<LookTable> table_;
};

}  // namespace

Agreement agreement_of_scans(std::vector<PlacedScan> scans, const AgreementOptions& options) {
  LookedAt looked(std::move(scans), options);
  looked.look_at_own_places(true);
  return looked.conclude();
}

Agreement agreement_with_map(std::vector<PlacedScan> scans, const std::vector<StoredScans>& map,
                             const AgreementOptions& options) {
  LookedAt looked(std::move(scans), options);
  looked.look_at_own_places(false);
  looked.look_at_map(map);
  return looked.conclude();
}

}  // namespace hybrid
