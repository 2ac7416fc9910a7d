// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, the hybrid mapping authors

#include "mrpt_plugins/plugins/read_landmark_options.h"

#include <optional>

namespace hybrid {

std::vector<std::string> read_sensors(IniSection& section) {
  return section.get("sensors", std::vector<std::string>{},
                     "labels of the sensors to use; empty: all");
}

ClassModel read_class_model(IniSection& section) {
  ClassOptions o;
  section.read("class_names", o.names, "classes of landmarks; empty: as the log names them");
  section.read("class_prior", o.prior,
               "probability of each class before any sighting; empty: all equal", kProbability);
  section.read("confusion", o.confusion,
               "p(detected class | true class), a row for each true class, in the order of "
               "class_names; empty: the scores of the log are taken as calibrated probabilities",
               kProbability);
  section.read(
      "score_floor", o.floor,
      "share of a detection that is a guess among all classes, so that none is ever ruled out",
      {1e-12, 1.0});
  if (const auto fault = find_fault(o)) section.fail(fault->key, fault->why);
  return ClassModel(o, "[" + section.name() + "]");
}

namespace {

void read_motion_prior(IniSection& section, MotionPrior& motion) {
  section.read("moving_share", motion.moving,
               "probability that a thing moves before any sighting: one for all, or one for each "
               "class in the order of class_names; 0: nothing moves",
               kProbability);
  if (motion.moving.empty()) section.fail("moving_share", "needs a probability");
  std::vector<double> speeds, accelerations;
  for (const MotionKind& kind : motion.kinds) {
    speeds.push_back(kind.speed);
    accelerations.push_back(kind.acceleration);
  }
  section.read("moving_speeds", speeds,
               "of things that move, the standard deviation of each component of the velocity, one "
               "for each kind of motion, such as walking and driving [m/s]",
               {1e-3, 1e4});
  if (speeds.empty()) section.fail("moving_speeds", "needs a speed");
  section.read("moving_acceleration", accelerations,
               "by which each component of it changes within a second: one for each kind of "
               "motion, or one for all [m/s]",
               {1e-4, 1e4});
  if (accelerations.size() == 1) accelerations.resize(speeds.size(), accelerations.front());
  if (accelerations.size() != speeds.size())
    section.fail("moving_acceleration", "needs one for each of moving_speeds, or one for all");
  motion.kinds.clear();
  for (std::size_t k = 0; k < speeds.size(); ++k)
    motion.kinds.push_back({speeds[k], accelerations[k]});
}

/// Which matchings are kept, for how long, and of which landmarks.
void read_what_stays_open(IniSection& section, AssociationOptions& o) {
  section.read("hypotheses", o.hypotheses, "joint matchings kept open for a frame", {1, 64});
  section.replace_all({"keep_open_odds", "old_landmark_odds", "clutter_odds"}, "open_odds");
  section.read(
      "keep_open_odds", o.keep_open_odds,
      "matchings are kept open that are less probable than the best by at most this factor",
      {1, 1e9});
  section.read("old_landmark_odds", o.old_landmark_odds,
               "odds at which a landmark from before the last stretch of the way is matched by one "
               "detection; where the drift lets fewer than one in so many be there by chance, no "
               "loops are looked for",
               {1, 1e9});
  section.read("window", o.window, "keyframes until an open matching is decided", {1, 1e6});
}

}  // namespace

AssociationOptions read_association_options(IniSection& section) {
  AssociationOptions o;
  const std::string method = section.choice(
      "method", "hypotheses", {"hypotheses", "nearest", "jcbb"},
      "hypotheses: the best joint matchings of a frame, kept open while they are close; nearest: "
      "maximum likelihood, detection by detection; jcbb: joint compatibility branch and bound");
  using Method = AssociationOptions::Method;
  if (method == "nearest") o.method = Method::kNearest;
  if (method == "jcbb") o.method = Method::kJcbb;
  section.read("use_ids", o.use_ids, "take the ids of the log where it has them");
  section.read("extent", o.extent,
               "of a landmark: the standard deviation of the places of things that are taken for "
               "it; things nearer to each other are not told apart [m]; one for all, or one for "
               "each class in the order of class_names",
               {0, 1e3});
  if (o.extent.empty()) section.fail("extent", "needs a length");
  section.read("gate", o.gate, "probability of the chi-square gate of an innovation",
               {0.5, 0.999999});
  section.replaces("information_penalty", "caution");
  section.read("information_penalty", o.information_penalty,
               "price of a match, in -log odds, for each nat that it would tell of pose and "
               "landmark: the less these are known, the better it must fit",
               {0, 1e3});
  read_what_stays_open(section, o);
  section.read("landmarks_in_view", o.landmarks_in_view,
               "landmarks expected in the field of view, before any is known", {1e-3, 1e6});
  section.read("clutter_in_view", o.clutter_in_view, "spurious detections expected in a frame",
               {1e-6, 1e6});
  section.read("detection_probability", o.detection_probability,
               "that a landmark in view is detected", {0.01, 0.99});
  section.read("confirm", o.confirm,
               "sightings until a landmark counts; until then it is tentative: it may be given up, "
               "is no landmark that others become, tells a place only where those that count do "
               "not, and in the end it is clutter",
               {1, 1e6});
  section.read("clutter_odds", o.clutter_odds,
               "odds that there is none at which a tentative landmark is given up", {1, 1e9});
  section.read("merge", o.merge, "find landmarks that are one, and so close loops");
  section.read("recent", o.recent,
               "landmarks seen within so many keyframes are compared with the others, and count as "
               "missed where they are not seen",
               {1, 1e6});
  section.read("merge_odds", o.merge_odds,
               "odds that decide whether landmarks are one: needed for a merge, and over one that "
               "contradicts it; what classes alone, or the places of single detections, tell apart "
               "by as much is not compared",
               {1, 1e12});
  read_motion_prior(section, o.motion);
  return o;
}

BankOptions read_bank_options(IniSection& section) {
  BankOptions o;
  section.read("dominance", o.dominance,
               "a landmark is placed once its best place has this probability", {0.5, 1.0});
  section.read("max_sigma", o.max_sigma,
               "and is known in every direction to this share of how far away it is", {1e-6, 10});
  section.read("min_measurements", o.min_measurements, "measurements before a decision", {1, 1e6});
  section.read("max_measurements", o.max_measurements, "kept of a landmark that has no place yet",
               {2, 1e6});
  section.read("outlier_share", o.outlier_share, "of measurements that are false", {1e-9, 0.5});
  section.read("drift", o.drift,
               "of the robot while a landmark has no place yet, added to the noise [m]", kLength);
  return o;
}

}  // namespace hybrid
