// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, the hybrid mapping authors

#pragma once

#include <cstddef>
#include <cstdint>
#include <map>
#include <utility>
#include <vector>

#include "libhybrid/landmarks/landmark_association.h"
#include "libhybrid/smoother/proposal.h"

namespace HYBRID_API hybrid {

/// Maps landmarks in the plane (SE2) or in space (SE3) from odometry and detections that nobody has
/// identified: the loop between LandmarkAssociation and a smoother in its smallest form. The map
/// begins with the first keyframe.
template <class Pose>
class LandmarkMapper {
 public:
  explicit LandmarkMapper(LandmarkAssociation association = LandmarkAssociation(),
                          const SmootherOptions& options = {})
      : association_(std::move(association)), smoother_(options) {}

  /// Adds a keyframe: the motion since the one before as measured, T_before_now, or where the robot
  /// starts, and what its sensors see. Returns whether the detections could be used; where they
  /// leave something undetermined, the motion alone is taken in. Throws Error, and adds nothing,
  /// where motion or detections make no sense.
  bool add(const Pose& motion, const Noise& noise, const std::vector<DetectionFrame>& detections);

  /// Decides what is still open, gives up landmarks that were seen too rarely, and solves to
  /// convergence.
  void finish();

  /// The variable of a keyframe, by number from 0.
  static Key pose_key(std::size_t i);
  std::size_t keyframes() const { return keyframes_; }
  const LandmarkRegistry& landmarks() const { return landmarks_; }
  const IncrementalSmoother& smoother() const { return smoother_; }
  const LandmarkAssociation& association() const { return association_; }
  /// Things that move, which are no landmarks, at those of the `times` (in order, [s], as those of
  /// the frames of detections) at which they were in sight.
  std::vector<Mover> movers(const std::vector<double>& times) const {
    return association_.movers(times, view());
  }
  /// What each landmark stands for, by id.
  std::map<std::int64_t, LandmarkSize> sizes() const { return association_.sizes(view()); }
  /// What became of every detection so far.
  std::vector<AssociationDecision> decisions() const { return association_.decisions(view()); }

 private:
  MapView view() const;
  UpdateReport::Status apply(const Contribution& contribution, const Delta& motion);
  void revise(bool concluding);

  LandmarkAssociation association_;
  IncrementalSmoother smoother_;
  LandmarkRegistry landmarks_;
  std::size_t keyframes_ = 0;
};

}  // namespace hybrid
