// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, the hybrid mapping authors

#pragma once

#include <map>
#include <optional>
#include <string>
#include <vector>

#include "libhybrid/detections/detection.h"
#include "libhybrid/geometry/eigen.h"
#include "libhybrid/geometry/se3.h"

namespace HYBRID_API hybrid {

struct DetectionTrackerOptions {
  /// Share of the variance of a detection that all detections of one thing have in common, so that
  /// it does not average out: how the shape of a thing is seen, how a sensor is calibrated.
  double common = 0.25;
  /// How long that lasts [s], beyond one release: a car that comes nearer is seen from the same
  /// side for seconds. What is handed on more often counts for less each time, so that the same
  /// detections tell the same however many keyframes there are. 0: it is another at each release.
  double lasts = 0.0;
  double gate = 0.99999;  ///< chi-square probability within which a detection continues a track
};

/// Follows what is seen from one keyframe to the next by odometry, over which far less is lost
/// between two frames than between two keyframes, and hands each thing on as one detection, with
/// the mean time of its detections and, where these are enough, the velocity that they show.
class DetectionTracker {
 public:
  explicit DetectionTracker(const DetectionTrackerOptions& options = {}) : options_(options) {}

  /// Takes the motion of the robot since the frame before, T_before_now, and its covariance in the
  /// tangent (translation, rotation) of a right perturbation; zero in what a plane has not.
  void move(const Eigen::Isometry3d& motion, const SE3::Jacobian& covariance);
  /// Takes what a sensor sees now. Detections with an id continue those with the same id, others
  /// the nearest place, one to one.
  void take(const DetectionFrame& frame);
  /// Everything since the last call, seen from where each sensor was at its first frame but given
  /// relative to the robot now: `T_robot_sensor` takes the motion in. Covariances hold the noise of
  /// the detections, what they have in common, and that of the motion since.
  std::vector<DetectionFrame> release();
  /// Gives up everything since the last release. Returns how many detections that were.
  std::size_t forget();

 private:
  struct Track {  // one thing, in the frame of the sensor at its first frame
    Eigen::MatrixXd information;
    Eigen::VectorXd information_mean;
    Eigen::MatrixXd information_time, information_time2;  // times the time, and its square
    Eigen::VectorXd information_mean_time;
    std::optional<std::int64_t> id;
    std::vector<double> class_evidence;  // sum of log p(scores | class)
    std::vector<std::optional<std::int64_t>> members;
    double steps = 0;    // sum over its detections of the frames since the first
    double seconds = 0;  // the same of the time

    void take(const Eigen::VectorXd& point, const Eigen::MatrixXd& covariance, double seconds);
    /// The steady velocity that fits its detections best, and its covariance as if their noise was
    /// independent; none for too few.
    std::optional<Detection::Velocity> velocity() const;
    Eigen::MatrixXd covariance() const { return information.inverse(); }
    Eigen::VectorXd mean() const { return covariance() * information_mean; }
  };
  struct Sensor {
    DetectionFrame first;           // without its detections
    Eigen::Isometry3d T_now_first;  // where it was then, from the robot now
    Eigen::Isometry3d T_then_now = Eigen::Isometry3d::Identity();  // motion of the robot since then
    SE3::Jacobian motion_covariance = SE3::Jacobian::Zero();       // of that
    int frames = 0;
    std::optional<double> interval;  // since the first frame of the release before [s]
    double seconds = 0;              // the longest time between the first frame and another
    double reach = 0;                // how far it has come [m]
    std::vector<Track> tracks;
  };
  struct Seen {
    Eigen::VectorXd point;
    Eigen::MatrixXd covariance;
  };

  static Seen place(const Sensor& sensor, const DetectionFrame& frame, const Detection& detection);
  std::vector<int> match(const Sensor& sensor, const std::vector<Seen>& seen,
                         const std::vector<Detection>& detections) const;
  Detection detection_of(const Sensor& sensor, const Track& track) const;
  double repetitions(const Sensor& sensor) const;

  /// By how much the variance of a mean of n detections exceeds that of independent ones.
  double inflation(const Track& track) const {
    const auto n = static_cast<double>(track.members.size());
    return (1 - options_.common) + options_.common * n;
  }

  DetectionTrackerOptions options_;
  std::map<std::string, Sensor> sensors_;     // by label
  std::map<std::string, double> last_times_;  // of first frames, of the last release
};

}  // namespace hybrid
