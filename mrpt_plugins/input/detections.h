// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, the hybrid mapping authors

#pragma once

#include <mrpt/obs/CObservation.h>

#include <cstdint>
#include <optional>
#include <set>

#include "libhybrid/detections/detection.h"
#include "mrpt_plugins/input/rawlog_reader.h"

namespace HYBRID_API hybrid {

/// Source of the landmark ids that the mapper receives.
enum class IdSource {
  kLog,    ///< Those of the sensor.
  kNone,   ///< None: they are kept as truth only, for evaluation.
  kTruth,  ///< The true ones, where the log has them: perfect association.
};

/// Limits and noise of measurements.
struct DetectionOptions {
  IdSource ids = IdSource::kLog;
  std::set<std::int64_t> robots = {};  ///< Ids of robots, which may be negative (but not -1).
  double max_range = 1000.0;           ///< Ranges beyond are dropped [m].
  /// Used in place of the sigmas of the log, where positive [m], [rad].
  double sigma_range = 0, sigma_yaw = 0, sigma_pitch = 0;
  /// Used if neither the above nor the log has a positive, finite sigma [m], [rad].
  double default_sigma_range = 0.1, default_sigma_angle = 0.02;
  /// Class probabilities are divided by their sum; a larger difference from 1 counts as a repair.
  double sum_tolerance = 1e-3;
};

/// The detections in a CObservationBearingRange or a CObservationClassedBearingRange; nothing for
/// other classes. A bearing-range observation is planar if it has no uncertainty in pitch and all
/// its pitches are zero.
///
/// Dropped, and counted in `report` by reason: detections with range, yaw or pitch not finite;
/// range not positive, above the limit or above that of the sensor; outside the field of view, such
/// as behind the sensor; |yaw| above 2 pi or |pitch| above pi/2; a sigma above the limit of range
/// or half a turn; an id seen before in the same observation; a covariance that is not positive
/// definite; whole observations whose sensor pose is not finite, no rigid motion, or farther from
/// the robot than the limit of range.
///
/// Repaired and counted: class scores of a wrong length, negative, not finite or all zero are
/// removed (the detection counts as not classified); other sums are normalised; sigmas that are
/// missing or below 1e-6 are replaced by the defaults; ids below -1 that are of no robot are taken
/// as none.
std::optional<DetectionFrame> detections_in(const mrpt::obs::CObservation& observation,
                                            const DetectionOptions& options, DropReport& report);

}  // namespace hybrid
