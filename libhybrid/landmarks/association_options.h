// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, the hybrid mapping authors

#pragma once

#include "libhybrid/export.h"
#include "libhybrid/movers/point_sighting.h"

namespace HYBRID_API hybrid {

/// How detections without an id find their landmarks. One set of defaults serves all sensors: what
/// differs between them is taken from their range, field of view and noise.
struct AssociationOptions {
  /// kHypotheses: k-best joint matchings, undecided ones stay open as a discrete variable.
  /// kNearest: the nearest landmark within the gate, detection by detection (maximum likelihood).
  /// kJcbb: joint compatibility branch and bound.
  enum class Method { kHypotheses, kNearest, kJcbb };
  Method method = Method::kHypotheses;
  bool use_ids = true;  ///< known-id override: ids of the log, where it has them
  /// Of a landmark: how far from it is what is taken for it, a standard deviation along each axis
  /// [m]. Things nearer to each other than that are not told apart where the map does not tell.
  double extent = 0;
  double gate = 0.9999;                ///< chi-square probability of an innovation
  double information_penalty = 1.0;    ///< price of a match per nat of what it would tell
  int hypotheses = 8;                  ///< at most, per frame
  double open_odds = 10;               ///< a hypothesis this much less probable is not kept open
  int window = 20;                     ///< keyframes until an open decision is taken
  double landmarks_in_view = 5;        ///< expected landmarks in the field of view of the sensor
  double clutter_in_view = 0.5;        ///< expected spurious detections per frame
  double detection_probability = 0.5;  ///< of a landmark in view
  int confirm = 2;                     ///< sightings that make a landmark
  bool merge = true;                   ///< find landmarks that are one, close loops by consensus
  int recent = 30;          ///< keyframes: landmarks seen within may be merged into others
  double merge_odds = 100;  ///< evidence that a merge needs
  MotionPrior motion = {};  ///< of things that move and are no landmarks
};

}  // namespace hybrid
