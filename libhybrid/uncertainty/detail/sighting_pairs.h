// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, the hybrid mapping authors
#pragma once

#include <array>
#include <cstdint>
#include <optional>
#include <vector>

#include "libhybrid/geometry/se3.h"
#include "libhybrid/uncertainty/detail/variance_components.h"

namespace hybrid {

/// The unknown variances: of a range r and of angles at r, constant and by range, or factors of
/// those stated; and factors of those of the odometry.
enum NoisePart { kRange, kRangeShare, kAngle, kAcross, kTranslation, kRotation };

inline constexpr int kLogParts = 10;  ///< of a log, for the jackknife

/// A detection in polar coordinates: range, yaw, pitch.
struct PolarSighting {
  Eigen::Vector3d z = Eigen::Vector3d::Zero();
  Eigen::Vector3d stated = Eigen::Vector3d::Zero();  ///< variances
  Eigen::Vector3d point = Eigen::Vector3d::Zero();   ///< in the frame of the odometry
  std::optional<std::int64_t> id;
  int track = -1;  ///< the thing it is of, where it was followed
};

/// One frame, with sums over the motions so far that give the noise of any motion between two.
struct PolarFrame {
  double time = 0;
  int chain = 0, part = 0;
  SE3 T_odometry_sensor;
  std::vector<PolarSighting> seen;
  double translation = 0, rotation = 0;                     ///< variances summed
  Eigen::Vector3d moment = Eigen::Vector3d::Zero();         ///< of rotation, first
  Eigen::Matrix3d second_moment = Eigen::Matrix3d::Zero();  ///< and second
};

struct PolarLog {
  int axes = 2;  ///< 2: range and yaw; 3: and pitch
  std::vector<PolarFrame> frames;
};

/// What a detection of one frame leads to expect in another.
struct ExpectedSighting {
  Eigen::Vector3d z = Eigen::Vector3d::Zero();
  std::array<Components, 3> shares;  ///< of the variances, in each of (range, yaw, pitch)
};

ExpectedSighting expected_sighting(const PolarFrame& from, const PolarSighting& seen,
                                   const PolarFrame& to, bool by_stated);

/// z less what is expected, the yaw as an arc.
Eigen::Vector3d innovation_of(const ExpectedSighting& expected, const Eigen::Vector3d& z);

/// A detection and the one nearest to it of a few frames before.
struct SightingPair {
  std::size_t first_frame = 0, second_frame = 0;
  int first = 0, second = 0;
  double density = 0;      ///< of things where the sensor sees, per unit of the innovation
  double clutter = 0;      ///< that of the innovation if they are of two things
  double probability = 1;  ///< that they are of one
};

/// Pairs of mutual nearest neighbours, under variances.
std::vector<SightingPair> nearest_pairs(const PolarLog& log, const Components& variances);

}  // namespace hybrid
