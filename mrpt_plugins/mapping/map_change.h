// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, the hybrid mapping authors

#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "libhybrid/landmarks/landmark_events.h"
#include "libhybrid/smoother/report.h"

namespace HYBRID_API hybrid {

/// One update of the map by the back-end, for the events file: its effect on the estimate, and the
/// reasons of the plugins. Landmarks are born before the other events of the change, and forgotten
/// after them.
struct MapChange {
  std::vector<double> objectives;  ///< after every half-step; empty if nothing was solved
  std::vector<Flip> flipped;       ///< discrete variables that changed, by half-step
  std::vector<std::int64_t> born, forgotten;  ///< ids of landmarks
  LandmarkEvents why;
  std::string refused;  ///< why a contribution was refused; all other fields are empty then
};

}  // namespace hybrid
