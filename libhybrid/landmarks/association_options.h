// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, the hybrid mapping authors

#pragma once

#include <vector>

#include "libhybrid/core/option.h"
#include "libhybrid/export.h"
#include "libhybrid/movers/point_sighting.h"

namespace HYBRID_API hybrid {

/// How detections without an id find their landmarks. One set of defaults serves all sensors: what
/// differs between them is taken from their range, field of view and noise.
struct AssociationOptions {
  enum class Method { kHypotheses, kNearest, kJcbb };
  static constexpr Named<Method> kMethods[] = {
      {"hypotheses", Method::kHypotheses}, {"nearest", Method::kNearest}, {"jcbb", Method::kJcbb}};
  Method method = Method::kHypotheses;
  bool use_ids = true;
  std::vector<double> extent = {0};
  double gate = 0.9999;
  double information_penalty = 1.0;
  int hypotheses = 8;
  double keep_open_odds = 10;
  double old_landmark_odds = 10;
  int window = 20;
  double landmarks_in_view = 5;
  double clutter_in_view = 0.5;
  double detection_probability = 0.5;
  int confirm = 2;
  double clutter_odds = 10;
  bool merge = true;
  int recent = 30;
  double merge_odds = 100;
  MotionPrior motion = {};  ///< of things that move and are no landmarks

  template <class Table>
  static void describe(Table& table) {
    using O = AssociationOptions;
    table.choice(
        "method", &O::method,
        "hypotheses: the best joint matchings of a frame, kept open while they are close; nearest: "
        "maximum likelihood, detection by detection; jcbb: joint compatibility branch and bound",
        kMethods);
    table.option("use_ids", &O::use_ids, "take the ids of the log where it has them");
    table.option("extent", &O::extent, {0, 1e3},
                 "of a landmark: the standard deviation of the places of things that are taken for "
                 "it; things nearer to each other are not told apart [m]; one for all, or one for "
                 "each class in the order of class_names");
    table.option("gate", &O::gate, {0.5, 0.999999},
                 "probability of the chi-square gate of an innovation");
    table.option("information_penalty", &O::information_penalty, {0, 1e3},
                 "price of a match, in -log odds, for each nat that it would tell of pose and "
                 "landmark: the less these are known, the better it must fit");
    table.option("hypotheses", &O::hypotheses, {1, 64}, "joint matchings kept open for a frame");
    table.option(
        "keep_open_odds", &O::keep_open_odds, {1, 1e9},
        "matchings are kept open that are less probable than the best by at most this factor");
    table.option("old_landmark_odds", &O::old_landmark_odds, {1, 1e9},
                 "odds at which a landmark from before the last stretch of the way is matched by "
                 "one detection; where the drift lets fewer than one in so many be there by "
                 "chance, no loops are looked for");
    table.option("window", &O::window, {1, 1e6}, "keyframes until an open matching is decided");
    table.option("landmarks_in_view", &O::landmarks_in_view, {1e-3, 1e6},
                 "landmarks expected in the field of view, before any is known");
    table.option("clutter_in_view", &O::clutter_in_view, {1e-6, 1e6},
                 "spurious detections expected in a frame");
    table.option("detection_probability", &O::detection_probability, {0.01, 0.99},
                 "that a landmark in view is detected");
    table.option("confirm", &O::confirm, {1, 1e6},
                 "sightings until a landmark counts; until then it is tentative: it may be given "
                 "up, is no landmark that others become, tells a place only where those that count "
                 "do not, and in the end it is clutter");
    table.option("clutter_odds", &O::clutter_odds, {1, 1e9},
                 "odds that there is none at which a tentative landmark is given up");
    table.option("merge", &O::merge, "find landmarks that are one, and so close loops");
    table.option("recent", &O::recent, {1, 1e6},
                 "landmarks seen within so many keyframes are compared with the others, and count "
                 "as missed where they are not seen");
    table.option("merge_odds", &O::merge_odds, {1, 1e12},
                 "odds that decide whether landmarks are one: needed for a merge, and over one "
                 "that contradicts it; what classes alone, or the places of single detections, "
                 "tell apart by as much is not compared");
  }
};

}  // namespace hybrid
