// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, the hybrid mapping authors

#pragma once

#include <array>
#include <string>
#include <vector>

#include "libhybrid/export.h"
#include "mrpt_plugins/mapping/map_result.h"

namespace HYBRID_API hybrid {

/// Names of the values of FixMode.
inline constexpr std::array kFixModes{"good", "biased", "false"};

/// True modes of motion, one whole number per row: row i has the mode of the motion to step i of
/// the log. Empty lines and comments (`%` or `#`) are skipped. Throws Error with file:line for
/// anything else, and for a file without rows.
std::vector<int> read_true_modes(const std::string& path);

/// What a fix of a satellite receiver really is.
struct TrueFix {
  double time = 0;  ///< its stamp in the log [s]
  FixMode mode = FixMode::kGood;
};

/// Reads `time,mode,error_east,error_north,error_up` below its titles, a row per fix in the order
/// of the log; the mode is good, biased or false. The order of times is restored where rows lack
/// it. Throws Error with file:line for anything else, and for a file without rows.
std::vector<TrueFix> read_true_fixes(const std::string& path);

}  // namespace hybrid
