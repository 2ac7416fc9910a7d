// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, the hybrid mapping authors
#include "libhybrid/scans/scan_match.h"

#include <Eigen/LU>
#include <algorithm>
#include <cmath>
#include <cstddef>

#include "libhybrid/core/evenly_chosen.h"

namespace hybrid {
namespace {

/// Cells of the field, and the scatter of returns that includes their discretisation [m].
constexpr double kResolution = 0.1;
constexpr double kFieldSigma = 0.12;
/// Errors that all points of an alignment share: of the map, of the calibration [m], [rad].
constexpr double kSharedTranslation = 0.005;
constexpr double kSharedRotation = 0.0015;
/// Standard deviations of what an alignment does not tell [m], [rad].
constexpr double kUnknownTranslation = 20.0;
constexpr double kUnknownRotation = 2.0;
/// Counterparts of points at a mode of the search are sought within this [m].
constexpr double kModeRadius = 0.4;
/// Modes that alignment moves closer together than this are one [m], [rad].
constexpr double kOneMode = 0.1;
constexpr double kOneModeTurn = 0.03;

bool is_one_mode(const SE2& a, const SE2& b) {
  const SE2 d = a.between(b);
  return d.translation().norm() < kOneMode && std::abs(d.angle()) < kOneModeTurn;
}

}  // namespace

MatchTarget make_match_target(const std::vector<SurfacePoint>& points) {
  MatchTarget target;
  target.surfaces = SurfaceMap(points);
  target.field = LikelihoodField(positions_of(target.surfaces.surfels()), kResolution, kFieldSigma);
  return target;
}

Eigen::Matrix3d alignment_covariance(const ScanAlignment& alignment) {
  const Eigen::Vector3d unknown(kUnknownTranslation, kUnknownTranslation, kUnknownRotation);
  const Eigen::Vector3d shared =
      Eigen::Vector3d(kSharedTranslation, kSharedTranslation, kSharedRotation) /
      std::max(alignment.inliers, 0.1);
  Eigen::Matrix3d information = alignment.information;
  information.diagonal() += unknown.cwiseAbs2().cwiseInverse();
  Eigen::Matrix3d covariance = information.inverse();
  covariance.diagonal() += shared.cwiseAbs2();
  return 0.5 * (covariance + covariance.transpose());
}

std::vector<MatchMode> match(const std::vector<SurfacePoint>& points, const MatchTarget& target,
                             const SearchWindow& window, const MatchOptions& options) {
  std::vector<MatchMode> modes;
  const auto used =
      evenly_chosen(positions_of(points), static_cast<std::size_t>(options.most_points));
  for (const SearchMode& mode : search_poses(used, target.field, window, options.search)) {
    AlignmentOptions alignment_options;
    alignment_options.radius = kModeRadius;
    const ScanAlignment alignment = align(points, target.surfaces, mode.pose, alignment_options);
    if (alignment.inliers < options.min_inliers) continue;
    const bool known = std::any_of(modes.begin(), modes.end(), [&](const MatchMode& other) {
      return is_one_mode(other.pose.motion, alignment.pose);
    });
    if (known) continue;
    modes.push_back({{alignment.pose, alignment_covariance(alignment)}, alignment.inliers});
  }
  std::stable_sort(modes.begin(), modes.end(),
                   [](const MatchMode& a, const MatchMode& b) { return a.inliers > b.inliers; });
  return modes;
}

}  // namespace hybrid
