// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, the hybrid mapping authors

#pragma once

#include <vector>

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
  /// [m]; one for all, or one for each class: a car is seen now here, now there. Things nearer to
  /// each other than that are not told apart where the map does not tell.
  std::vector<double> extent = {0};
  double gate = 0.9999;              ///< chi-square probability of an innovation
  double information_penalty = 1.0;  ///< price of a match per nat of what it would tell
  int hypotheses = 8;                ///< at most, per frame
  double keep_open_odds = 10;        ///< a hypothesis this much less probable is not kept open
  /// Of a landmark from before the last stretch of the way: odds at which it is told from its
  /// neighbours by one detection. Where the drift lets fewer than one in so many be there by
  /// chance, each is, and no loops are looked for.
  double old_landmark_odds = 10;
  int window = 20;                     ///< keyframes until an open decision is taken
  double landmarks_in_view = 5;        ///< expected landmarks in the field of view of the sensor
  double clutter_in_view = 0.5;        ///< expected spurious detections per frame
  double detection_probability = 0.5;  ///< of a landmark in view
  int confirm = 2;                     ///< sightings that make a landmark of a tentative one
  double clutter_odds = 10;            ///< against a tentative landmark, at which it is given up
  bool merge = true;                   ///< find landmarks that are one, close loops by consensus
  /// Keyframes: of landmarks seen within, it is known well enough where they are. They are compared
  /// with others, which they may be, and a look that misses them speaks against them.
  int recent = 30;
  /// Odds that decide whether landmarks are one: of a merge, over one that contradicts it. What
  /// classes alone, or the places of single detections, tell apart by as much is not compared.
  double merge_odds = 100;
  MotionPrior motion = {};  ///< of things that move and are no landmarks
};

}  // namespace hybrid
