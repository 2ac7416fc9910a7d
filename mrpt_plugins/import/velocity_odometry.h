// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, the hybrid mapping authors

#pragma once

#include <functional>
#include <optional>
#include <string>

#include "libhybrid/io/text_reader.h"
#include "mrpt_plugins/input/odometry.h"

namespace HYBRID_API hybrid {

/// Velocity of a vehicle in the plane from a time on.
struct Velocity {
  double time = 0;     ///< [s]
  double forward = 0;  ///< [m/s]
  double turn = 0;     ///< [rad/s], to the left.
};

/// Random walk of an odometry: sigmas grow with the square root of the distance travelled and of
/// the angle turned.
struct OdometryWalk {
  double along = 0, across = 0;  ///< [m per sqrt(m)]
  double heading = 0;            ///< [rad per sqrt(m)]
  double turning = 0;            ///< [rad per sqrt(rad)]
  double rest = 1e-4;            ///< Of every motion [m], [rad].

  /// Variances (x, y [m], angle [rad]) of a way [m] and a turn [rad], neither negative, beside what
  /// every motion has.
  Eigen::Vector3d variances(double way, double turn) const;
};

/// Integrates velocity readings streamed from a table. Each reading holds until the next one.
class VelocityOdometry {
 public:
  /// `read` converts a row into a velocity. Throws Error for a missing file; decreasing times throw
  /// Error with file:line during move_to().
  VelocityOdometry(const std::string& path, std::function<Velocity(const TextRow&)> read,
                   const OdometryWalk& walk);

  /// The motion since the last call; the first call sets the start time. The vehicle rests before
  /// the first reading.
  OdometryIncrement move_to(double time);

  /// Distance travelled [m].
  double way() const { return way_; }

 private:
  void advance();
  void roll(double time, OdometryIncrement& motion);

  TextReader table_;
  std::function<Velocity(const TextRow&)> read_;
  OdometryWalk walk_;
  std::optional<Velocity> next_;
  std::optional<double> time_;
  Velocity now_;
  double way_ = 0;
};

}  // namespace hybrid
