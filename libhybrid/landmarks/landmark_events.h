// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, the hybrid mapping authors

#pragma once

#include <cstdint>
#include <limits>
#include <memory>
#include <optional>
#include <utility>
#include <vector>

#include "libhybrid/core/key.h"
#include "libhybrid/detections/detection.h"

namespace HYBRID_API hybrid {

/// A landmark that a detection may be of, judged by itself.
struct SightingCandidate {
  std::int64_t landmark = 0;
  double nis = 0;             ///< r' S^-1 r of the innovation r under the joint covariance
  double class_log_odds = 0;  ///< part of the log odds that the class scores make up
  /// Against a landmark not seen before and clutter together [nats]; -infinity where the landmark
  /// was not admitted, for instance outside of the gate.
  double log_odds = -std::numeric_limits<double>::infinity();
};

/// A detection at the time when it came, and what it was taken for then.
struct SightingEvent {
  std::int64_t number = -1;  ///< of the detection among those of its plugin; -1: it keeps none
  Key pose;                  ///< of its keyframe
  std::shared_ptr<const DetectionFrame> sensor;  ///< without its detections
  Detection detection;
  std::optional<std::int64_t> landmark;  ///< none: not decided, or not used
  std::optional<double> nis;             ///< of the innovation, where the landmark was known before
  std::vector<SightingCandidate> candidates;  ///< most probable first
  /// p(class scores | class) up to a common factor, by class of the map; empty if nothing is known.
  std::vector<double> class_likelihood;
};

/// The ways to see the detections of a frame together that were close enough to be kept.
struct AssociationEvent {
  struct Hypothesis {
    std::vector<std::optional<std::int64_t>> landmarks;  ///< by sighting; none: new, or clutter
    double log_odds = 0;  ///< against the best one [nats], never positive
  };
  Key pose;
  std::vector<std::int64_t> sightings;  ///< numbers of them
  std::vector<Hypothesis> hypotheses;   ///< best first
  bool open = false;                    ///< whether the graph keeps several as a discrete variable
};

/// What a sighting was decided to be that was left open, or that was taken for something else.
struct DecisionEvent {
  std::int64_t sighting = 0;  ///< its number
  std::optional<std::int64_t> landmark;
  bool revised = false;  ///< whether it is not what it was taken for at first
};

/// Landmarks that were made one, the first of each pair into the second, or not.
struct MergeEvent {
  std::vector<std::pair<std::int64_t, std::int64_t>> pairs;
  bool loop = false;      ///< places recognised by several landmarks: a closed loop
  bool undone = false;    ///< turned down, since the objective would rise by more than is allowed
  double evidence = 0;    ///< log odds that they are one [nats]
  double chi_square = 0;  ///< of their differences, jointly
  /// By how much the objective may rise.
  double allowed_rise() const { return evidence + 0.5 * chi_square; }
};

/// Why a contribution is what it is; births and removals of landmarks stand in the contribution.
struct LandmarkEvents {
  std::vector<DecisionEvent> decisions;
  std::vector<SightingEvent> sightings;
  std::vector<AssociationEvent> associations;
  std::vector<MergeEvent> merges;
  std::vector<double> class_prior;  ///< of a landmark not seen before; empty without classes
};

}  // namespace hybrid
