// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, the hybrid mapping authors
#pragma once

#include <string>

#include "libhybrid/core/key.h"
#include "libhybrid/core/option.h"
#include "libhybrid/core/variable.h"

namespace HYBRID_API hybrid {

/// What of the past stays in the graph.
struct WindowOptions {
  enum class Mode {
    kFull,      ///< everything: full smoothing
    kFixedLag,  ///< variables that a factor touched within the last `lag` updates
    kFilter,    ///< the newest states and all else, i.e. landmarks
    kBounded    ///< what the place takes, however long the robot stays
  };
  Mode mode = Mode::kFull;
  int lag = 50;
  int complete = 3000;
  /// The end of a chain, which no factor ties to a newer state, and all other variables stay.
  int sightings = 50;
  /// As far as a break of the chain of states costs little; two priors on nearly the same variables
  /// become one of at most twice as many.
  int tied = 40;
  std::string lasting = {};
  /// E.g. "x" for vectors in a Kalman filter.
  std::string states = {};

  template <class Table>
  static void describe(Table& table) {
    using O = WindowOptions;
    table.field("mode", &O::mode,
                "everything, the last updates, the newest states, or what the place takes");
    table.option("complete", &O::complete, {0, 1e9},
                 "bounded: keyframes up to which nothing is marginalised");
    table.option("sightings", &O::sightings, {1, 1e9},
                 "bounded: later, a keyframe stays until this many newer ones have seen each of "
                 "the landmarks that it saw");
    table.field("tied", &O::tied,
                "bounded: what leaves ties so many variables by one prior, at most");
    table.option("lag", &O::lag, {0, 1e9},
                 "keyframes that a variable stays after its last measurement where mode is "
                 "fixed_lag; 0: for ever");
    table.field("lasting", &O::lasting,
                "letters of variables that never leave, e.g. of calibrations, which all "
                "measurements share");
    table.field("states", &O::states,
                "letters of the states, or keyframes, which leave, and of which a filter keeps the "
                "newest; empty: all poses");
  }

  bool is_lasting(Key key) const { return names(lasting, key); }
  bool is_state(Key key, VariableType type) const {
    if (is_lasting(key)) return false;
    return states.empty() ? is_pose(type) : names(states, key);
  }

 private:
  static bool names(const std::string& letters, Key key) {
    return letters.find(key.letter()) != std::string::npos;
  }
};

}  // namespace hybrid
