// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, the hybrid mapping authors
#include "libhybrid/scans/rest_watch.h"

#include <algorithm>
#include <cmath>
#include <utility>

#include "libhybrid/scans/scan_alignment.h"
#include "libhybrid/scans/surface_map.h"

namespace hybrid {
namespace {

/// Odometry rests where it tells less motion from scan to scan than this [m], [rad].
constexpr double kRest = 1e-3;
/// Points that are nearer to each other than this are of one place: several times the noise of a
/// laser [m].
constexpr double kSame = 0.1;
/// Share of the points that are elsewhere. What moves around a robot that rests is less; along a
/// corridor, most walls look the same.
constexpr double kMoved = 0.25;
/// Least part of these that is nearer, and that is farther, than what was there: who steps before
/// the laser is nearer, and what was behind them is farther.
constexpr double kBoth = 0.1;
/// Scans of fewer points tell nothing.
constexpr std::size_t kFewPoints = 10;

/// Whether many of the points, of those in the view of the others, are where these have none.
bool are_elsewhere(const std::vector<SurfacePoint>& points,
                   const std::vector<SurfacePoint>& others) {
  const ScanView view(others);
  std::size_t seen = 0, nearer = 0, farther = 0;
  for (const SurfacePoint& p : points) {
    if (!view.contains(p.position)) continue;
    ++seen;
    const SurfacePoint* beside = nullptr;  // the one in the most similar direction
    double most = -1;
    bool is_same = false;
    for (const SurfacePoint& other : others) {
      is_same = is_same || (p.position - other.position).squaredNorm() < kSame * kSame;
      const double cosine = p.position.dot(other.position) / other.position.norm();
      if (cosine > most) {
        most = cosine;
        beside = &other;
      }
    }
    if (is_same || beside == nullptr) continue;
    ++(p.position.norm() < beside->position.norm() ? nearer : farther);
  }
  const auto moved = static_cast<double>(nearer + farther);
  return seen >= kFewPoints && moved > kMoved * static_cast<double>(seen) &&
         static_cast<double>(std::min(nearer, farther)) > kBoth * moved;
}

}  // namespace

bool RestWatch::is_moved(const std::vector<SurfacePoint>& points,
                         const std::optional<SE2>& odometry) {
  const auto before =
      std::exchange(before_, std::make_shared<const std::vector<SurfacePoint>>(points));
  if (!odometry || !before || std::min(before->size(), points.size()) < kFewPoints) return false;
  const bool rests = odometry->translation().norm() < kRest && std::abs(odometry->angle()) < kRest;
  if (!rests || !are_elsewhere(points, *before)) return false;
  // Odometry may be late by a scan, in which a robot moves little.
  const SE2 near = align(points, SurfaceMap(*before), SE2()).pose;
  return are_elsewhere(transformed(near, points), *before);
}

}  // namespace hybrid
