// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, the hybrid mapping authors

#pragma once

#include <functional>
#include <optional>
#include <string>

#include "libhybrid/io/text_reader.h"
#include "mrpt_plugins/input/odometry.h"

namespace HYBRID_API hybrid {

/// What a vehicle in the plane does from one instant on.
struct Velocity {
  double time = 0;     ///< [s]
  double forward = 0;  ///< [m/s]
  double turn = 0;     ///< [rad/s], to the left.
};

/// Random walk of an odometry: standard deviations grow with the square root of the way and of the
/// angle turned.
struct OdometryWalk {
  double along = 0, across = 0;  ///< [m per sqrt(m)]
  double heading = 0;            ///< [rad per sqrt(m)]
  double turning = 0;            ///< [rad per sqrt(rad)]
  double rest = 1e-4;            ///< [m] and [rad], of every motion.
};

/// Adds up readings of velocity, each of which holds until the next one, streamed from a table.
class VelocityOdometry {
 public:
  /// `read` turns a row into a velocity. Throws Error for a missing file; times that go backwards
  /// throw Error with file:line while moving.
  VelocityOdometry(const std::string& path, std::function<Velocity(const TextRow&)> read,
                   const OdometryWalk& walk);

  /// Motion since the call before; the first call starts the clock. Before the first reading the
  /// vehicle rests.
  OdometryIncrement move_to(double time);

  /// Length of the way so far [m].
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
