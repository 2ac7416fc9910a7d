// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, the hybrid mapping authors

#pragma once

#include <Eigen/Geometry>
#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "libhybrid/association/prediction.h"
#include "libhybrid/core/loss.h"
#include "libhybrid/detections/detection.h"
#include "libhybrid/factors/factor.h"
#include "libhybrid/movers/point_sighting.h"

namespace HYBRID_API hybrid {

/// Whether a sensor is one of those to use; none of these are all.
bool is_wanted(const std::string& sensor, const std::vector<std::string>& sensors);

/// Why a map of this dimension cannot use the ranges and directions of a frame; empty if it can.
std::string misfit(const DetectionFrame& frame, bool is_3d);
/// The same where directions are enough.
std::string misfit_of_bearing(const DetectionFrame& frame, bool is_3d);

/// The Gaussian psi(x, p) of eq. 19: range and direction of point `point` from pose `pose`, through
/// the place of the sensor on the robot.
ContinuousFactorPtr sighting_factor(Key pose, Key point, const DetectionFrame& frame,
                                    const Detection& detection, bool is_3d, Loss loss = {});

/// The direction alone, with a standard deviation added to its noise [rad].
ContinuousFactorPtr bearing_factor(Key pose, Key point, const DetectionFrame& frame,
                                   const Detection& detection, bool is_3d, double extra_sigma = 0);

/// By detection, whether more than 10 others of its frame are as near as two sightings of one thing
/// would be by their noise, or most of the frame is such: which is which nobody can tell then.
std::vector<bool> are_crowded(const DetectionFrame& frame);

/// Standard deviation of where a detection puts its thing, of the usual axis [m].
double position_sigma(const Detection& detection, bool is_3d);

/// What an extent adds to the noise of (range, yaw, pitch) of a detection there: a standard
/// deviation along each axis [m].
Eigen::Matrix3d noise_of_extent(double range, double pitch, double extent, bool is_3d);

/// The detection of a landmark with an extent: of the landmark itself or of something about it,
/// which along each axis is so far off, a standard deviation [m].
Detection with_extent(Detection detection, double extent, bool is_3d);

/// Range and direction of a detection, as a map in space or in the plane takes them. Nearer than
/// three sigmas of its range, where the sensor may be on either side of the thing, all directions
/// are alike: its position is known across no better than along. Else a bearing from a thing that
/// is passed at a hand's breadth would hold it on the wrong side, against all other sightings.
MeasuredPoint measured_point(const Detection& detection, bool is_3d);

/// The position of the landmark that the log gives this id.
Key position_key(std::int64_t id);

/// Where the detection puts its landmark in the map [m].
Eigen::Vector3d sighted_point(const Eigen::Isometry3d& T_map_robot, const DetectionFrame& frame,
                              const Detection& detection);

/// The same of a frame of this time, with the velocity if measured, and the covariance of the
/// detection alone.
PointSighting point_sighting(const Eigen::Isometry3d& T_map_sensor, double time,
                             const Detection& detection, bool is_3d);

}  // namespace hybrid
