// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, the hybrid mapping authors

#pragma once

#include <cstddef>
#include <cstdint>
#include <deque>
#include <functional>
#include <map>
#include <string>
#include <vector>

#include "libhybrid/core/loss.h"
#include "libhybrid/core/values.h"
#include "libhybrid/detections/detection.h"
#include "libhybrid/factors/factor.h"

namespace HYBRID_API hybrid {

/// The motion of a robot from one keyframe to the next, as its odometry measures it.
struct RobotMotion {
  Key before;                ///< the pose that it starts from
  double from = 0, to = 0;   ///< [s]
  Eigen::Isometry3d motion;  ///< T_before_after
  /// In the tangent (translation, rotation) of a right perturbation; zero in what a plane has not.
  Eigen::Matrix<double, 6, 6> covariance;
};

/// Robots that see each other. A robot is seen between two of its keyframes: it is taken to be
/// where its odometry puts it at that time, seen from the keyframe before, with the share of the
/// noise of the odometry that belongs to the way up to there. Sightings of one motion have that
/// noise in common. So a sighting waits for the next keyframe of the robot that was seen.
class RobotSightings {
 public:
  /// The loss of all factors.
  explicit RobotSightings(Loss loss = {}) : loss_(loss) {}

  /// What robot `observer` sees of others at its keyframe `pose`: detections whose ids are those of
  /// robots, `robot_of` tells whose. Sightings of oneself are dropped.
  void take(std::size_t observer, Key pose, double time, const std::vector<DetectionFrame>& frames,
            const std::map<std::int64_t, std::size_t>& robot_of);

  /// The factors of what was seen of a robot up to the end of a motion. `values` holds the poses of
  /// all keyframes before; sightings whose poses are not `held` any more are dropped.
  std::vector<ContinuousFactorPtr> met(std::size_t robot, const RobotMotion& motion,
                                       const Values& values, bool is_3d,
                                       const std::function<bool(Key)>& held);
  /// Drops what was seen of a robot up to a time for which there is no motion.
  void miss(std::size_t robot, double until);

  std::size_t used() const { return used_; }
  /// Reason -> number of sightings that were not used. Those that still wait count too.
  std::map<std::string, std::size_t> dropped() const;

 private:
  struct Sighting {
    std::size_t seen;
    Key pose;  // of the observer
    double time;
    DetectionFrame frame;  // without its detections
    Detection detection;
  };

  /// Of one of the sightings that were made `together`, during one motion.
  template <class Pose>
  ContinuousFactorPtr factor(const Sighting& sighting, std::size_t together,
                             const RobotMotion& motion, const Values& values) const;

  Loss loss_;
  std::deque<Sighting> waiting_;
  std::size_t used_ = 0;
  std::map<std::string, std::size_t> dropped_;
};

}  // namespace hybrid
