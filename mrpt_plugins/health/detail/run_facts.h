// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, the hybrid mapping authors

#pragma once

#include <Eigen/Geometry>
#include <cstddef>
#include <cstdint>
#include <map>
#include <optional>
#include <set>
#include <vector>

#include "libhybrid/marginals/continuous.h"
#include "mrpt_plugins/bridge/poses.h"
#include "mrpt_plugins/health/run_health.h"

namespace hybrid {

/// A detection that the map holds to be of a landmark.
struct FactOfSighting {
  std::size_t pose = 0;
  std::int64_t landmark = 0;
  double range = 0, yaw = 0;  ///< of what was measured, seen from the robot [m], [rad]
};

/// A measured motion from a pose to the next one of the robot; covariance of its tangent
/// (translation, rotation), in the plane at kPlanarIndices only.
struct FactOfMotion {
  std::size_t to = 0;
  Eigen::Isometry3d measured;
  Matrix6d covariance;
};

/// What the checks of a run share.
struct RunFacts {
  explicit RunFacts(const RunToJudge& run);

  const RunToJudge& run;
  std::vector<const ContinuousFactor*> factors;  ///< of measurements, as the assignment has them
  std::size_t false_ranges = 0, ranges = 0;      ///< taken for false, and all, of mixtures
  std::vector<FactOfSighting> sightings;
  std::map<std::size_t, FactOfMotion> motions;  ///< by the pose that they begin at
  /// Poses that are in the graph, with all that was measured there; others have left a window.
  std::set<std::size_t> in_graph;
  /// Those of them from which a detector looked: others are of other sensors.
  std::set<std::size_t> looked_from;
  /// Poses that a landmark was seen from, of these.
  std::map<std::int64_t, std::set<std::size_t>> seen_from;
  /// Nothing where the covariances cannot be had.
  std::optional<ContinuousMarginals> marginals;

  Eigen::Isometry3d pose(std::size_t i) const;
  /// A figure of the plugins; 0 where they have none of that name.
  double figure(const char* name) const;
  /// Whether laser scans alone tell of the path, beside odometry.
  bool is_by_scans() const { return sightings.empty() && figure("scans") > 0; }
};

/// Limits of the factor by which a scale of odometry that scans tell is off one: wheels are worn or
/// measured badly by a few per cent. By more, it is something else, as a field of view that is
/// stated wrongly.
inline constexpr UpperLimits kWheelLimits{1.05, 1.1};
/// The factor by which a scale is off one, either way; of a negative one, the most.
double factor_off(double scale);

/// The entries of each kind.
void check_residuals(const RunFacts& facts, Health& health);
void check_landmarks(const RunFacts& facts, Health& health);
void check_path(const RunFacts& facts, Health& health);
void check_detections(const RunFacts& facts, Health& health);
void check_clouds(const RunFacts& facts, Health& health);
void check_scans(const RunFacts& facts, Health& health);
void check_fixes(const RunFacts& facts, Health& health);

}  // namespace hybrid
