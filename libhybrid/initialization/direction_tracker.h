// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, the hybrid mapping authors

#pragma once

#include <cstddef>
#include <map>
#include <optional>
#include <string>
#include <vector>

#include "libhybrid/detections/detection.h"
#include "libhybrid/geometry/eigen.h"
#include "libhybrid/geometry/se3.h"

namespace HYBRID_API hybrid {

struct DirectionTrackerOptions {
  double least_depth = 1;    ///< Of a thing at first sight [m]; farther ones may be anywhere.
  double range_sigma = 0.3;  ///< A range is known where its sigma is at most this share of it.
  double gate = 0.9999;      ///< chi-square probability within which a direction continues a track
  double memory = 2;         ///< A thing that nobody saw for so long is given up [s].
  /// Share of the variance of a direction that all directions of one thing have in common.
  double common = 0.25;
};

/// Follows things that a sensor sees by direction alone, without ids: a direction continues the
/// track whose thing lies there as far as is known, and whose classes agree best, one to one. While
/// the robot passes a thing its directions cross; once they tell its range, the thing is handed on
/// as one detection with a range, and what comes after starts the next one. No direction is used in
/// two of them.
///
/// The state of a track is direction and inverse range from the sensor as it stands now, by least
/// squares over all its directions, with the covariance of the motion between them.
class DirectionTracker {
 public:
  explicit DirectionTracker(const DirectionTrackerOptions& options = {}) : options_(options) {}

  /// Takes the motion of the robot since the frame before, T_before_now, and its covariance in the
  /// tangent (translation, rotation) of a right perturbation; zero in what a plane has not.
  void move(const Eigen::Isometry3d& motion, const SE3::Jacobian& covariance);
  /// Takes what a sensor sees now.
  void take(const DetectionFrame& frame);
  /// The things whose ranges have become known, as their sensors see them now.
  std::vector<DetectionFrame> release();

  /// Directions so far, and those that are part of what was released.
  std::size_t taken() const { return taken_; }
  std::size_t released() const { return released_; }
  /// Things that are followed now.
  std::size_t followed() const;

 private:
  struct Instant {  // a frame, seen from where the robot is now
    Eigen::Isometry3d T_then_now = Eigen::Isometry3d::Identity();
    SE3::Jacobian covariance = SE3::Jacobian::Zero();  // of the motion since
  };
  struct Measurement {
    std::size_t instant = 0;
    Eigen::Vector3d z;           // yaw, pitch, inverse range
    Eigen::Matrix3d covariance;  // of these
    bool has_direction = true, has_inverse_range = false;
  };
  struct Track {
    std::vector<Measurement> prior, seen;  // what is known from before; what is not handed on yet
    Eigen::Vector3d state;                 // yaw, pitch, inverse range, from the sensor now
    Eigen::Matrix3d covariance = Eigen::Matrix3d::Zero();
    std::optional<std::int64_t> id;
    std::vector<double> evidence, evidence_seen;       // log p(scores | class): all, and of `seen`
    std::vector<std::optional<std::int64_t>> members;  // true ids, of `seen`
    double last_time = 0;
    std::size_t last_instant = 0;
  };
  struct Sensor {
    DetectionFrame frame;  // the last one, without detections
    std::vector<Track> tracks;
  };
  struct Fit {
    Eigen::Vector3d state;
    Eigen::Matrix3d covariance = Eigen::Matrix3d::Zero();
    double chi_square = 0;
    int redundancy = 0;
  };

  double own_covariance(const Measurement& a, int p, const Measurement& b, int q) const;
  std::optional<Fit> fit(const Sensor& sensor, const std::vector<Measurement>& all,
                         const Eigen::Vector3d& start) const;
  std::optional<Fit> range_of(const Sensor& sensor, const Track& track) const;
  std::vector<int> match(const Sensor& sensor, const DetectionFrame& frame) const;
  void begin(Sensor& sensor, const Detection& detection);
  void extend(const Sensor& sensor, Track& track, const Detection& detection);
  void update(const Sensor& sensor, Track& track) const;
  Detection detection_of(const Track& track, const Fit& fit) const;
  bool is_old(const Sensor& sensor, const Track& track) const;
  void prune();

  DirectionTrackerOptions options_;
  std::size_t now_ = 0;
  std::map<std::size_t, Instant> instants_;  // that measurements are of
  std::map<std::string, Sensor> sensors_;    // by label
  std::size_t taken_ = 0, released_ = 0;
};

}  // namespace hybrid
