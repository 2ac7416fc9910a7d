// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, the hybrid mapping authors

#pragma once

#include <cmath>
#include <map>
#include <string>

#include "libhybrid/core/key_letters.h"
#include "libhybrid/factors/bearing_range.h"
#include "libhybrid/factors/between.h"
#include "libhybrid/factors/calibrated_motion.h"
#include "libhybrid/factors/prior.h"
#include "libhybrid/geometry/so2.h"
#include "mrpt_plugins/bridge/pose_conversions.h"
#include "mrpt_plugins/health/run_health.h"
#include "tests/support/random.h"

namespace hybrid::testing {

inline constexpr int kPoses = 400, kThings = 12;
inline constexpr double kScale = 1.2;  // of odometry that is calibrated
inline constexpr double kRangeSigma = 0.1, kYawSigma = 0.01, kMoveSigma = 0.02, kTurnSigma = 0.01;

/// What is stated wrongly.
struct Stated {
  double range = 1, move = 1;  ///< sigmas, times so much
  bool copies = false;         ///< a second landmark for every second thing
  int late = 0;                ///< keyframes by which the motion lags
  int seen = 1;                ///< one of so many looks sees
  double turned = 0;           ///< yaw of the sensor on the robot, and back in its bearings [rad]
  double aside = 0;            ///< yaw that the sensor looks to [rad]
  bool calibrated = false;     ///< odometry is too short, and calibrated
  bool own_ids = false;        ///< each detection is of a landmark of its own
  bool by_scans = false;       ///< nothing is detected, the poses are known
  int every = 1;               ///< one of so many keyframes is of the detector
  int left = 0;                ///< keyframes whose measurements have left the window
};

inline Key pose_key(int i) {
  return Key(key_letter::kPose, static_cast<std::uint64_t>(i));
}
inline Key calibration_key() {
  return Key(key_letter::kOdometryCalibration, 0);
}
inline Key point_key(int k) {
  return Key(key_letter::kLandmark, static_cast<std::uint64_t>(k));
}

/// A robot that turns and speeds up and down among things; everything is where it really is.
class Walk {
 public:
  explicit Walk(const Stated& stated) : random_(7), stated_(stated) {
    place_poses();
    place_things();
    add_motions();
    result_.steps.resize(kPoses);
    for (int i = stated.left; i < kPoses; ++i) {
      result_.steps[i].has_detections = i % stated.every == 0;
      if (result_.steps[i].has_detections) look_from(i);
    }
  }

  Health health(std::size_t decided = 1) const {
    return run_health({graph_, estimate_, result_, dropped_, decided});
  }

  /// Of a log of scans, whose path agrees over time or was not judged.
  Health health_by_scans(bool agrees) const {
    return run_health({graph_, estimate_, result_, dropped_, 0, {{"scans", 100}}, agrees});
  }

  /// Of a log of detections that agrees over time.
  Health health_that_agrees() const {
    return run_health({graph_, estimate_, result_, dropped_, 1, {}, true});
  }

  void calibrate(double scale_of_rotation, double scale_of_translation = 1.01) {
    CalibrationEstimate odometry{"odometry",
                                 {{"scale of translation", "", scale_of_translation, 0.01, 1},
                                  {"scale of rotation", "", scale_of_rotation, 0.01}}};
    for (auto& entry : odometry.entries) entry.observed = true;
    result_.calibration = {odometry};
  }

  std::map<std::string, std::size_t> dropped_;

 private:
  void place_poses() {
    SE2 pose;
    for (int i = 0; i < kPoses; ++i) {
      estimate_.values.insert(pose_key(i), pose);
      result_.trajectory.push_back({0.5 * i, to_mrpt(pose)});
      pose = pose * SE2::exp(Eigen::Vector3d(0.3 + 0.2 * std::sin(0.3 * i), 0,
                                             0.08 + 0.07 * std::sin(0.23 * i)));
    }
  }
  void place_things() {
    for (int k = 0; k < kThings; ++k) {
      const double a = 2 * M_PI * k / kThings;
      add_landmark(k, {8 * std::cos(a), 4 + 8 * std::sin(a)});
      if (stated_.copies && k % 2 == 0) {
        add_landmark(100 + k, {8.1 * std::cos(a), 4 + 8.1 * std::sin(a)});
      }
    }
  }
  void add_landmark(int id, const Eigen::Vector2d& at) {
    estimate_.values.insert(point_key(id), at);
    LandmarkEstimate landmark;
    landmark.id = id;
    landmark.position = {at.x(), at.y(), 0};
    landmark.class_index = id % 2;
    result_.landmarks.push_back(landmark);
  }
  void add_motions() {
    if (stated_.calibrated) {
      const OdometryCalibration2 calibration(kScale, 1, 0);
      estimate_.values.insert(calibration_key(), calibration);
      graph_.emplace<Prior<Eigen::Vector3d>>(calibration_key(), calibration,
                                             Noise::isotropic(3, 0.01));
    }
    graph_.emplace<Prior<SE2>>(pose_key(stated_.left),
                               estimate_.values.at<SE2>(pose_key(stated_.left)),
                               Noise::isotropic(3, 1e-3));
    const Noise noise =
        Noise::diagonal(Eigen::Vector3d(kMoveSigma, kMoveSigma, kTurnSigma) * stated_.move);
    for (int i = stated_.left; i + 1 < kPoses; ++i) {
      const int from = std::min(i + stated_.late, kPoses - 2);
      const SE2 truth = estimate_.values.at<SE2>(pose_key(from)).inverse() *
                        estimate_.values.at<SE2>(pose_key(from + 1));
      const Eigen::Vector3d error(random_.normal(kMoveSigma), random_.normal(kMoveSigma),
                                  random_.normal(kTurnSigma));
      const SE2 z = truth * SE2::exp(error);
      if (stated_.calibrated) {
        const SE2 measured(z.translation() / kScale, z.rotation());
        graph_.emplace<CalibratedMotion2>(pose_key(i), pose_key(i + 1), calibration_key(), measured,
                                          noise);
      } else {
        graph_.emplace<Between<SE2>>(pose_key(i), pose_key(i + 1), z, noise);
      }
    }
  }
  void look_from(int i) {
    const Noise noise = Noise::diagonal(Eigen::Vector2d(kRangeSigma * stated_.range, kYawSigma));
    const SE2 T = estimate_.values.at<SE2>(pose_key(i));
    const Noise matched = Noise::isotropic(3, kYawSigma);
    if (stated_.by_scans) return void(graph_.emplace<Prior<SE2>>(pose_key(i), T, matched));
    for (int k = 0; k < kThings; ++k) {
      int id = stated_.copies && k % 2 == 0 && i % 2 == 0 ? 100 + k : k;
      const Eigen::Vector2d at = estimate_.values.at<Eigen::Vector2d>(point_key(id));
      const Eigen::Vector2d p = T.inverse() * at;
      const double yaw = std::atan2(p.y(), p.x());
      if (p.norm() > 10 || std::abs(wrap_angle(yaw - stated_.aside)) > 1) continue;
      if (random_.below(stated_.seen) != 0) continue;
      if (stated_.own_ids) add_landmark(id = 1000 + kThings * i + k, at);
      graph_.emplace<BearingRange<SE2>>(
          pose_key(i), point_key(id),
          Eigen::Vector2d(p.norm() + random_.normal(kRangeSigma),
                          wrap_angle(yaw - stated_.turned + random_.normal(kYawSigma))),
          noise, SE2(0, 0, stated_.turned));
    }
  }

  Random random_;
  Stated stated_;
  HybridGraph graph_;
  Estimate estimate_;
  MapResult result_;
};

}  // namespace hybrid::testing
