// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, the hybrid mapping authors
#pragma once

#include <array>
#include <cstddef>
#include <utility>
#include <vector>

#include "libhybrid/uncertainty/sensor_delay.h"

namespace hybrid {

// Of the log, for the jackknife: so many that what a few of them tell, as turns do of a delay, has
// a standard deviation too.
inline constexpr Eigen::Index kAlignmentParts = 30;

using PartCosts = Eigen::Array<double, kAlignmentParts, 1>;

/// What is asked: a sign of bearings, a yaw of the mounting, a delay of the clock; a slow turn of
/// the odometry, which looks much like a yaw where all that is seen is far away; and what lengths
/// of the odometry are to be multiplied by to be in the unit of the ranges.
struct AlignmentChange {
  bool mirrored = false;
  double yaw = 0, delay = 0, drift = 0;  // rad, s, rad/s
  double length = 1;
};

struct AlignedSighting {
  Eigen::Vector3d z, point, mirrored;  // as it is; and points in the frame of the sensor
  Eigen::Vector3d variance;
};

struct AlignedFrame {
  double time = 0;
  SE3 T_robot_sensor;
  std::vector<AlignedSighting> seen;
};

/// The earliest frame within a second before, or the one before.
struct FramePair {
  std::size_t first = 0, second = 0;
};

/// Half the Hessian of a cost and half its gradient, over yaw, delay and drift: that with weights
/// as they are, which is never negative, and the true one, by which the least moves.
struct AlignmentSystem {
  Eigen::Matrix3d H = Eigen::Matrix3d::Zero(), true_H = Eigen::Matrix3d::Zero();
  Eigen::Vector3d g = Eigen::Vector3d::Zero();
  void add(const AlignmentSystem& other, double factor) {
    H += factor * other.H;
    true_H += factor * other.true_H;
    g += factor * other.g;
  }
};

/// How well pairs of frames agree.
class AlignmentCost {
 public:
  /// Of sightings for which there is odometry whatever the delay, of up to `longest_delay` [s].
  AlignmentCost(const std::vector<OdometryPose>& odometry,
                const std::vector<TimedSightings>& sightings, double longest_delay);

  std::size_t pairs() const { return pairs_.size(); }

  /// Pairs that are kept.
  std::size_t used() const { return (pairs_.size() + stride_ - 1) / stride_; }

  /// Keeps as many pairs, evenly, as the comparisons allow.
  void limit(double comparisons);

  /// The squared distances of one change, by part of the log.
  std::array<std::vector<double>, kAlignmentParts> distances(const AlignmentChange& change) const;

  PartCosts costs(const AlignmentChange& change, double scale) const;

  /// The costs by stretch of the log, each so long that what is odd in one frame is in no other.
  std::vector<double> costs_by_stretch(const AlignmentChange& change, double scale) const;

  /// The normal equations by part of the log, with matches as they are and weights by the distances
  /// (Geman-McClure). Where a thing leaves the view, its match is wrong on one side only: by
  /// Cauchy's loss these drew the yaw by more than it is uncertain.
  std::array<AlignmentSystem, kAlignmentParts> linearize(const AlignmentChange& change,
                                                         double scale) const;

  /// Sums over pairs of how far the robot moves and turns between their frames.
  std::pair<double, double> motion() const;

 private:
  /// Exceeded by a tenth.
  static double upper(std::vector<double> values);

  double comparisons_of(const FramePair& p) const;

  SE3 sensor_at(const AlignedFrame& frame, const AlignmentChange& change) const;
  SE3 motion_of(const AlignedFrame& a, const AlignedFrame& b, const AlignmentChange& change) const;

  static Eigen::Vector3d expected_of(const AlignedSighting& s, const SE3& T_b_a, bool mirrored);

  static Eigen::Vector3d innovation(const AlignedSighting& s, const AlignedSighting& t,
                                    const SE3& T_b_a, bool mirrored);

  /// What the second frame saw nearest to a sighting of the first, and how far it is.
  static std::pair<const AlignedSighting*, double> nearest_to(const AlignedSighting& s,
                                                              const AlignedFrame& b,
                                                              const SE3& T_b_a, bool mirrored);

  const std::vector<OdometryPose>& odometry_;
  std::vector<AlignedFrame> frames_;
  std::vector<FramePair> pairs_;
  std::size_t stride_ = 1;
};

}  // namespace hybrid
