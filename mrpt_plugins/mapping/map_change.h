// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, the hybrid mapping authors

#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "libhybrid/landmarks/landmark_events.h"
#include "libhybrid/smoother/report.h"

namespace HYBRID_API hybrid {

/// One change of the map, which the back-end took as a whole: what it did to the estimate, and why
/// it was made. Landmarks are born before, and forgotten after, all else that it tells.
struct MapChange {
  std::vector<double> objectives;  ///< after every half-step; empty where nothing was solved
  std::vector<Flip> flipped;       ///< discrete variables that changed, by half-step
  std::vector<std::int64_t> born, forgotten;  ///< ids of landmarks
  LandmarkEvents why;
  std::string refused;  ///< why what a plugin said could not be taken; all else is empty then
};

}  // namespace hybrid
