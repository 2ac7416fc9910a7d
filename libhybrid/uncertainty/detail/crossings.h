// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, the hybrid mapping authors

#pragma once

#include <cstddef>
#include <vector>

#include "libhybrid/uncertainty/agreement.h"

namespace hybrid {

/// What directions say of ranges: those of every second instant of a sensor cross, and those of the
/// others are looks that had no part in it.
struct Crossings {
  /// Of stretches of the log, evenly spread, along the path in each: a frame with ranges, of the
  /// time of the middle of the stretch [s], as seen from where it ends.
  std::vector<PlacedDetections> places;
  /// By place of `places`, the positions of the looks during its stretch.
  std::vector<std::vector<std::size_t>> looks;
};

/// `frames` are in order of time; those with ranges say nothing.
Crossings crossings(const std::vector<PlacedDetections>& frames, double stretch);

}  // namespace hybrid
