// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, the hybrid mapping authors

#pragma once

#include <Eigen/Geometry>
#include <cstddef>
#include <map>
#include <string>

#include "libhybrid/detections/detection.h"
#include "libhybrid/geometry/eigen.h"

namespace HYBRID_API hybrid {

/// What a sensor can see, which gives the densities of new landmarks and clutter their units.
struct SensorCoverage {
  double min_range = 0, max_range = 0;  ///< [m]
  double fov_yaw = 0, fov_pitch = 0;    ///< full angles [rad]; no pitch for a planar sensor
  double center_yaw = 0;                ///< the middle of what is in view [rad]
  double detections = 0;                ///< so far
  double around = 0;                    ///< sum over them of the landmarks in view with them
  double in_view = 0, seen = 0;         ///< landmarks that were in view, and that were detected

  /// Landmarks to expect in view where there is one: `before` any frame, then more and more what
  /// there were. Landmarks come in clusters, so this is more than the mean over all frames.
  double expected_in_view(double before) const;
  /// That a landmark in view is detected: `before` any frame, then more and more as it was.
  double detection_probability(double before) const;
  /// As the frame says, or the farthest and the most to the side so far where it says nothing;
  /// where all is to one side, from the one end to the other.
  void learn(const DetectionFrame& frame);
  /// Volume of its measurements, range times angles.
  double measurement_volume() const;
  /// Area in view [m^2], or volume in space [m^3].
  double space_in_view() const;
  /// Landmarks per m^2, or m^3, with so many `expected_in_view` before any frame.
  double density(double before) const { return expected_in_view(before) / space_in_view(); }
  /// Whether a point of the map is so far within range and field of view that it would be seen.
  bool well_in_view(const Eigen::Isometry3d& T_map_sensor, const Eigen::Vector3d& point) const;

 private:
  /// The directions of all detections, which lie from `rightmost_` to the left up to `leftmost_`.
  void learn_direction(double yaw);
  bool looks_aside() const;

  double rightmost_ = 0, leftmost_ = 0;  // [rad]
  double symmetric_ = 0;                 // full angle about the axis that holds all [rad]
  std::size_t directions_ = 0;
};

/// Landmarks of a map per m^2, or m^3: as dense as any of its sensors finds them, since another may
/// overlook many, whichever of them has looked last. 0 where none has.
double density_of_landmarks(const std::map<std::string, SensorCoverage>& sensors, double before);

}  // namespace hybrid
