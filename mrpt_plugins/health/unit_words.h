// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, the hybrid mapping authors

#pragma once

#include <string>
#include <vector>

#include "mrpt_plugins/mapping/map_result.h"

namespace HYBRID_API hybrid {

/// What calibrated scales of the odometry say that no error of wheels explains: that ranges, or
/// angles, and odometry have not one unit. They are more than 5 percent off, by five sigmas.
std::vector<std::string> unit_words(const std::vector<CalibrationEstimate>& calibration);

}  // namespace hybrid
