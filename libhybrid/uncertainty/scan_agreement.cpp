// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, the hybrid mapping authors

#include <algorithm>
#include <cmath>
#include <optional>

#include "libhybrid/geometry/so2.h"
#include "libhybrid/uncertainty/detail/look_table.h"

namespace hybrid {
namespace {

constexpr std::size_t kMostScans = 1000;  // whose returns are looked at again
constexpr std::size_t kRays = 40;         // of each of them
constexpr double kReach = 12;             // [m]; rays spread, and graze what is farther away
constexpr double kShortest = 0.3;         // [m]; the robot itself is nearer
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
  const std::size_t count = std::min(kRays, rays.size());
  for (std::size_t i = 0; i < count; ++i) {
    const std::size_t ray = rays[i * rays.size() / count];
    const Eigen::Vector2d point = end_of(at, ray);
    const Eigen::Vector2d seen = point - at.T_map_sensor.translation();
    out.push_back({point, std::atan2(seen.y(), seen.x())});
  }
  return out;
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

bool may_see(const PlacedScan& a, const PlacedScan& b) {
  return (a.T_map_sensor.translation() - b.T_map_sensor.translation()).norm() < 2 * kReach;
}

}  // namespace

Agreement agreement_of_scans(std::vector<PlacedScan> scans, const AgreementOptions& given) {
  scans.erase(std::remove_if(scans.begin(), scans.end(),
                             [](const PlacedScan& at) {
                               return at.scan->ranges.size() < 3 || at.scan->angle_step == 0;
                             }),
              scans.end());
  if (scans.empty()) return {};
  std::stable_sort(scans.begin(), scans.end(),
                   [](const auto& a, const auto& b) { return a.time < b.time; });
  const auto options = options_for(given, scans.back().time - scans.front().time);
  LookTable table(scans.front().time, kReach);
  const std::size_t every = (scans.size() + kMostScans - 1) / kMostScans;
  for (std::size_t i = 0; i < scans.size(); i += every) {
    std::vector<std::size_t> near;
    std::vector<std::pair<double, int>> times;
    for (std::size_t j = 0; j < scans.size(); ++j) {
      if (!may_see(scans[i], scans[j])) continue;
      near.push_back(j);
      times.emplace_back(scans[j].time, scans[j].robot);
    }
    const auto looks = LookChoice(std::move(times), options).around(scans[i].time, scans[i].robot);
    for (const SurfacePlace& place : surfaces_of(scans[i])) {
      table.begin_place(scans[i].time);
      for (const auto& [when, j] : looks) look(place, scans[near[j]], when, table);
    }
  }
  Agreement out = table.conclude();
  out.far_from = options.far_from;
  return out;
}

}  // namespace hybrid
