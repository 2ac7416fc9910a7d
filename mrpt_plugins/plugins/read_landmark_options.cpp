// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, the hybrid mapping authors

#include "mrpt_plugins/plugins/read_landmark_options.h"

#include <optional>

#include "mrpt_plugins/bridge/read_options.h"

namespace hybrid {

std::vector<std::string> read_sensors(IniSection& section) {
  return section.get("sensors", std::vector<std::string>{},
                     "labels of the sensors to use; empty: all");
}

ClassModel read_class_model(IniSection& section) {
  ClassOptions o;
  read_options(section, o);
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

}  // namespace

AssociationOptions read_association_options(IniSection& section) {
  AssociationOptions o;
  section.replaces("information_penalty", "caution");
  section.replace_all({"keep_open_odds", "old_landmark_odds", "clutter_odds"}, "open_odds");
  read_options(section, o);
  if (o.extent.empty()) section.fail("extent", "needs a length");
  read_motion_prior(section, o.motion);
  return o;
}

BankOptions read_bank_options(IniSection& section) {
  BankOptions o;
  read_options(section, o);
  return o;
}

}  // namespace hybrid
