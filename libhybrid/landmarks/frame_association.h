// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, the hybrid mapping authors

#pragma once

#include <vector>

#include "libhybrid/association/prediction.h"
#include "libhybrid/detections/class_model.h"
#include "libhybrid/detections/sensor_coverage.h"
#include "libhybrid/landmarks/association_options.h"
#include "libhybrid/landmarks/contribution.h"
#include "libhybrid/landmarks/landmark_tracks.h"
#include "libhybrid/landmarks/views.h"

namespace HYBRID_API hybrid {

/// One way to see all detections of a frame.
struct FrameHypothesis {
  std::vector<int> track;        ///< by detection; -1 for a new landmark or clutter
  double cost = 0;               ///< -log evidence
  std::vector<double> constant;  ///< by detection, what its factor must add, see open_options
};

/// What is known about the detections of a frame and the landmarks that they may be.
struct FrameCandidates {
  std::vector<MeasuredPoint> measured;   ///< by detection
  std::vector<int> tracks;               ///< the candidates
  std::vector<double> sigmas;            ///< of each, at most, of its position in the map [m]
  PredictedSightings predicted;          ///< of what the candidates stand for
  std::vector<Eigen::MatrixXd> extents;  ///< of each, what it adds to the noise of its sightings
  std::vector<GaussianScore> scores;     ///< of single pairs, by detection, then by candidate
  std::vector<double> undetected;  ///< by detection: share of landmarks, see Views::undetected
  Eigen::MatrixXd class_cost;      ///< -log p(class scores | candidate), detections x candidates
  MatchingProblem problem;         ///< costs of single pairs

  const GaussianScore& score(std::size_t detection, std::size_t candidate) const {
    return scores[detection * tracks.size() + candidate];
  }
};

/// What is known before the detections of a frame are matched.
struct FrameContext {
  const AssociationOptions& options;
  const SensorCoverage& coverage;  ///< of the sensor
  const ClassModel& classes;
  const Views& views;  ///< all looks so far
  Key recent_since;    ///< the pose with which the last stretch of the way begins
  const LandmarkTracks& landmarks;
};

/// The candidates of a frame: landmarks within the gate of a detection, by the joint covariance of
/// pose and landmarks. That a detection is of a new landmark is the less probable the more often
/// its place was looked at. `phi` holds the class likelihoods of each detection, or nothing.
FrameCandidates find_candidates(const KeyframeView& frame, const DetectionFrame& seen,
                                const std::vector<std::vector<double>>& phi, const MapView& map,
                                const FrameContext& context);

/// What was asked of the map about the candidates of a frame, whose detections are the `sightings`,
/// is noted for those that follow.
void note_candidates(const FrameCandidates& candidates, const std::vector<int>& sightings,
                     const MapView& map, LandmarkTracks& landmarks);

/// Ways to see the frame, best first, as the method chosen finds them; those but the best are close
/// to it.
std::vector<FrameHypothesis> find_hypotheses(const FrameCandidates& candidates,
                                             const AssociationOptions& options);

/// How the sightings of a frame were matched.
struct FrameMatching {
  std::vector<int> sightings;  ///< those that had to be matched
  FrameCandidates candidates;
  std::vector<FrameHypothesis> hypotheses;  ///< best first; none where there was nothing to match
  bool open = false;                        ///< whether several of them stay in the graph
};

}  // namespace hybrid
