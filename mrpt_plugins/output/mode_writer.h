// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, the hybrid mapping authors

#pragma once

#include <cstddef>
#include <optional>
#include <string>
#include <vector>

#include "mrpt_plugins/mapping/map_result.h"

namespace HYBRID_API hybrid {

/// The modes of motion as CSV: keyframe, time (s), mode, and the probability of each mode. A row
/// has the mode of the motion to its keyframe.
std::string modes_csv(const MapResult& result);

/// How well modes other than the first (such as slip) are detected.
struct ModeScore {
  std::size_t motions = 0;  ///< motions with an estimated and a true mode
  std::size_t found = 0;    ///< of them, estimated as other than the first
  std::size_t real = 0;     ///< truly other than the first
  std::size_t both = 0;     ///< both estimated and truly other than the first
  double precision() const { return found == 0 ? 1.0 : double(both) / double(found); }
  double recall() const { return real == 0 ? 1.0 : double(both) / double(real); }
};

/// Compares with true modes, given by row of the log; `log_rows` are the rows of the poses. Throws
/// Error for a row beyond the truth.
ModeScore score_modes(const MapResult& result, const std::vector<std::size_t>& log_rows,
                      const std::vector<int>& truth);

}  // namespace hybrid
