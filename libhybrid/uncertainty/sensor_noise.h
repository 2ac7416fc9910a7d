// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, the hybrid mapping authors
#pragma once

#include <cstddef>
#include <limits>
#include <string>
#include <vector>

#include "libhybrid/uncertainty/sensor_delay.h"

namespace HYBRID_API hybrid {

/// A measured number and its standard deviation by the jackknife over ten parts of the log.
struct Measured {
  double value = 0;
  double sigma = std::numeric_limits<double>::infinity();

  /// Whether it is known to 15 percent.
  bool is_sure() const;
  /// Whether it is better than what is stated: it is sure, or the log tells at least that stated is
  /// wrong by a factor of 1.5, by three standard deviations.
  bool replaces(double stated) const;
};

/// The noise of a sensor of ranges and directions and of the odometry that moves it.
struct SensorNoise {
  /// Why nothing was measured; empty where something was.
  std::string unknown;
  /// Whether what the log states fits but for a factor; else the sigma of a range r is
  /// hypot(range_m, range_share r), that of angles hypot(angle_rad, across_m / r).
  bool is_scaled = false;
  double range_factor = 1, angle_factor = 1;
  double range_m = 0, range_share = 0, angle_rad = 0, across_m = 0;
  /// At the median range of what was seen, errors that last included.
  Measured range, angle;
  double stated_range = 0, stated_angle = 0;  ///< there, root mean squares
  double at_range = 0;                        ///< that median [m]
  /// How errors grow with the time between two sightings of one thing: their sigma over that after
  /// the first time. What is common to all things seen, such as errors of odometry, is left out.
  struct Lag {
    double seconds = 0;
    double range = 1, angle = 1;
    std::size_t pairs = 0;  ///< of frames
  };
  std::vector<Lag> lags;
  /// Whether errors do not last, as far as things stay in view, 2 s at least: sightings far apart
  /// disagree no more than successive ones. Else what is measured is less than the noise there is,
  /// and what lasts cannot be told from errors of odometry.
  bool is_white() const;
  /// Of the odometry: standard deviations over those stated, over the time that things stay in
  /// view.
  Measured translation, rotation;
  std::size_t pairs = 0;  ///< of successive sightings of one thing
  double chance = 0;      ///< expected number of other things as near as the noise leads
};

/// Measures the noise without a map: each sighting is matched to the nearest of those of a few
/// frames before, moved by odometry, both ways; wrong pairs are those of Poisson clutter, told from
/// right ones by a mixture; and variances are fitted to what right ones disagree by, over several
/// times between two sightings. Frames in the order of time. What depends on where a thing is seen
/// from does not show while the robot rests: such frames count only where the others tell nothing.
SensorNoise measure_sensor_noise(const std::vector<MovedSightings>& frames);

}  // namespace hybrid
