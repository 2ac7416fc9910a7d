// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, the hybrid mapping authors
#pragma once

#include <string>

#include "libhybrid/core/key.h"
#include "libhybrid/core/variable.h"

namespace HYBRID_API hybrid {

/// What of the past stays in the graph.
struct WindowOptions {
  enum class Mode {
    kFull,      ///< everything: full smoothing
    kFixedLag,  ///< variables that a factor touched within the last `lag` updates
    kFilter,    ///< the newest states and all else, i.e. landmarks
    kBounded    ///< what the place takes, however long the robot stays: see `sightings`
  };
  Mode mode = Mode::kFull;
  int lag = 50;  ///< in updates; 0 or less is no limit
  /// A bounded window is full smoothing until more states than this have entered.
  int complete = 3000;
  /// From then on a state leaves once this many newer ones hold each variable that it shares a
  /// factor with, i.e. have seen each landmark that it saw, and as many are newer at all. The end
  /// of a chain, which no factor ties to a newer state, and all other variables stay.
  int sightings = 50;
  /// What leaves ties no more than so many of them together by one prior, as far as a break of the
  /// chain of states costs little; two priors on nearly the same ones become one of at most twice
  /// as many.
  int tied = 40;
  /// Letters of variables that never leave, e.g. of calibrations, which all measurements share.
  std::string lasting = {};
  /// Letters of the states, which a bounded window lets go and of which a filter keeps those of the
  /// newest update that brings some, e.g. "x" for vectors in a Kalman filter; empty: all poses
  /// (SE2, SE3).
  std::string states = {};

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
