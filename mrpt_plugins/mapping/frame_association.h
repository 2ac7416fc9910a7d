// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, the hybrid mapping authors

#pragma once

#include <vector>

#include "libhybrid/association/prediction.h"
#include "mrpt_plugins/mapping/association_options.h"
#include "mrpt_plugins/mapping/class_model.h"
#include "mrpt_plugins/mapping/mapping_plugin.h"
#include "mrpt_plugins/mapping/track_book.h"

namespace hybrid {

/// What a sensor can see, which gives the densities of new landmarks and clutter their units.
struct SensorReach {
  double min_range = 0, max_range = 0;  ///< [m]
  double fov_yaw = 0, fov_pitch = 0;    ///< full angles [rad]; no pitch for a planar sensor
  double detections = 0;                ///< so far
  double around = 0;                    ///< sum over them of the landmarks in view with them
  double in_view = 0, seen = 0;         ///< landmarks that were in view, and that were detected

  /// Landmarks to expect in view where there is one: `before` any frame, then more and more what
  /// there were. Landmarks come in clusters, so this is more than the mean over all frames.
  double expected_in_view(double before) const;
  /// That a landmark in view is detected: `before` any frame, then more and more as it was.
  double detection_probability(double before) const;
  /// As the frame says, or the farthest and the most to the side so far where it says nothing.
  void learn(const DetectionFrame& frame);
  /// Volume of its measurements, range times angles.
  double measurement_volume() const;
  /// Area in view [m^2], or volume in space [m^3].
  double space_in_view() const;
};

/// One way to see all detections of a frame.
struct FrameHypothesis {
  std::vector<int> track;        ///< by detection; -1 for a new landmark or clutter
  double cost = 0;               ///< -log evidence
  std::vector<double> constant;  ///< by detection, what its factor must add, see open_options
};

/// What is known about the detections of a frame and the landmarks that they may be.
struct FrameCandidates {
  std::vector<MeasuredPoint> measured;  ///< by detection
  std::vector<int> tracks;              ///< the candidates
  PredictedSightings predicted;         ///< of the candidates
  Eigen::MatrixXd class_cost;  ///< -log p(class scores | candidate), detections x candidates
  MatchingProblem problem;     ///< costs of single pairs
};

/// The candidates of a frame: landmarks within the gate of a detection, by the joint covariance of
/// pose and landmarks. `phi` holds the class likelihoods of each detection, or nothing.
FrameCandidates find_candidates(const Frame& frame, const DetectionFrame& seen,
                                const std::vector<std::vector<double>>& phi, const MapView& map,
                                const SensorReach& reach, const ClassModel& classes,
                                const AssociationOptions& options, TrackBook& book);

/// Ways to see the frame, best first, as the method chosen finds them; those but the best are close
/// to it.
std::vector<FrameHypothesis> find_hypotheses(const FrameCandidates& candidates,
                                             const AssociationOptions& options);

/// Probability of each candidate, and last of none of them, for one detection.
std::vector<double> responsibilities(const FrameCandidates& candidates, int detection);

}  // namespace hybrid
