// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, the hybrid mapping authors
#pragma once

#include <cstddef>
#include <cstdint>
#include <optional>
#include <vector>

#include "libhybrid/uncertainty/sensor_noise.h"

namespace HYBRID_API hybrid {

/// Whether ids of a sensor are of things, or of a tracker that gives a thing a new id whenever it
/// comes back into view.
struct IdReturns {
  std::size_t ids = 0;
  std::size_t again = 0;     ///< those seen in more than one frame
  std::size_t due = 0;       ///< those whose place came into view again after 5 s, by odometry
  std::size_t returned = 0;  ///< of all, seen again after 5 s

  /// Of ids that were due the share that returned; where fewer than ten were due, of all the share
  /// that was seen in more than one frame. Nothing where there are fewer than ten.
  std::optional<double> share() const;
  /// Hardly any: the ids are those of a tracker, or of detections.
  bool are_of_a_tracker() const { return share().value_or(1) < kLeastReturning; }
  static constexpr double kLeastReturning = 0.05;
};

/// Counts them over the frames of one sensor, in the order of time. A place counts as in view where
/// the sensor sees most: well within the ranges and angles at which it detected anything. Odometry
/// that drifts makes some places due that are not, but then ids that last return all the same.
IdReturns count_id_returns(const std::vector<MovedSightings>& frames);

/// An id that two things have.
struct SharedId {
  std::int64_t id = 0;
  double apart = 0;  ///< of the two [m]
};

/// Ids that are seen at one place and soon after at another, several times at each, farther apart
/// than the noise of detections and five times that of odometry allow. Nothing where more than a
/// quarter of the ids are such.
std::vector<SharedId> shared_ids(const std::vector<MovedSightings>& frames);

}  // namespace hybrid
