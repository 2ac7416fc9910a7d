// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, the hybrid mapping authors

#pragma once

#include <Eigen/Core>
#include <cstddef>
#include <vector>

#include "libhybrid/movers/point_sighting.h"

namespace HYBRID_API hybrid {

/// Position and velocity of a thing that keeps its velocity but for white noise of acceleration: a
/// Kalman filter in D coordinates.
template <int D>
struct VelocityState {
  using Mean = Eigen::Matrix<double, 2 * D, 1>;
  using Covariance = Eigen::Matrix<double, 2 * D, 2 * D>;
  Mean mean;
  Covariance covariance;

  /// What is known of a thing that moves once it was seen, its velocity if measured left out;
  /// `speed` is the standard deviation of each component of that beforehand [m/s].
  VelocityState(const PointSighting& seen, double speed);
  /// The transition over `dt` seconds.
  static Covariance transition(double dt);
  /// The state after `dt` seconds, see MotionKind::acceleration.
  void predict(double dt, double acceleration);
  /// log p of the position (and, if measured, the velocity) of a sighting at the time of the state;
  /// takes it in.
  double take(const PointSighting& seen);
  /// The same of a measured velocity alone.
  double take_velocity(const PointSighting& seen);
};

/// Whether one thing stands or moves, by what was seen of it: a switching system of modes that do
/// not change into each other, each with its exact marginal likelihood.
template <int D>
class MotionFilter {
 public:
  MotionFilter(const PointSighting& first, const MotionPrior& prior);

  /// Takes in a sighting, not earlier than the last one. To a thing that stands it adds
  /// information or, where that is more probable, it is the first of another one: `births` is the
  /// density of things that were not seen before [1 / m^D].
  void take(const PointSighting& seen, double births);

  /// log density of a sighting if the thing moves with probability `moving` before any of them.
  double log_density(const PointSighting& seen, double moving) const;

  /// log p(sightings | it moves) - log p(sightings | it stands).
  double evidence() const;
  /// The most probable kind of motion, if it moves: its number in the prior.
  std::size_t likeliest_kind() const;

 private:
  using Point = Eigen::Matrix<double, D, 1>;
  using Covariance = Eigen::Matrix<double, D, D>;

  double log_standing(const PointSighting& seen) const;

  struct Motion {  // one kind of motion
    VelocityState<D> state;
    double acceleration;
    double evidence;  // log p(sightings | it moves so)
  };

  double time_;
  Point standing_;
  Covariance standing_covariance_;
  double standing_evidence_;
  std::vector<Motion> motions_;
};

/// log odds that a thing moves: those of its prior and of the evidence.
double log_odds_of_motion(double evidence, double moving);

}  // namespace hybrid
