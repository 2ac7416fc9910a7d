// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, the hybrid mapping authors

#pragma once

#include <cstddef>
#include <optional>
#include <string>
#include <vector>

#include "mrpt_plugins/evaluation/mode_truth.h"
#include "mrpt_plugins/mapping/map_result.h"

namespace HYBRID_API hybrid {

/// The modes of motion as CSV: keyframe, time (s), mode, and the probability of each mode. A row
/// has the mode of the motion to its keyframe.
std::string modes_csv(const MapResult& result);

/// How well one kind of things is detected among others.
struct DetectionScore {
  std::size_t found = 0;  ///< estimated as of this kind
  std::size_t real = 0;   ///< truly of it
  std::size_t both = 0;   ///< both
  void add(bool is_found, bool is_real) {
    found += is_found;
    real += is_real;
    both += is_found && is_real;
  }
  double precision() const { return found == 0 ? 1.0 : double(both) / double(found); }
  double recall() const { return real == 0 ? 1.0 : double(both) / double(real); }
};

/// How well modes other than the first (such as slip) are detected.
struct ModeScore : DetectionScore {
  std::size_t motions = 0;  ///< motions with an estimated and a true mode
};

/// Compares with true modes, given by row of the log; `log_rows` are the rows of the poses. Throws
/// Error for a row beyond the truth.
ModeScore score_modes(const MapResult& result, const std::vector<std::size_t>& log_rows,
                      const std::vector<int>& truth);

/// How well it is told what fixes of satellite receivers are.
struct FixScore {
  std::size_t fixes = 0;  ///< with a true mode, that are in the map or were left out of it
  DetectionScore wrong;   ///< the false ones; those left out of the map count as found
  DetectionScore biased;
  /// Expected calibration error of the probabilities of the three modes, in ten bins; nothing where
  /// none are known.
  std::optional<double> calibration_error;
};

/// Compares fixes with true modes of the same times, in the order of the rows where times are
/// equal. A fix is what is most probable, or where probabilities are not known its mode.
FixScore score_fixes(std::vector<FixEstimate> fixes, const std::vector<TrueFix>& truth);

}  // namespace hybrid
