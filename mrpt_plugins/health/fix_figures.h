// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, the hybrid mapping authors

#pragma once

#include <cstddef>
#include <map>
#include <string>

#include "mrpt_plugins/health/health.h"
#include "mrpt_plugins/mapping/map_result.h"

namespace HYBRID_API hybrid {

/// What became of the fixes of a run.
struct FixFigures {
  std::size_t count = 0;  ///< that the plugin took
  std::size_t used = 0;   ///< in the map, each good, biased or false
  std::size_t good = 0, biased = 0, wrong = 0;
  std::map<std::string, std::size_t> wrong_of;  ///< of each receiver in the map, by label
  bool asks_modes = false;                      ///< else all of the map are called good
  std::size_t bias_runs = 0;
  double longest_bias = 0;  ///< run of biased fixes [s]
  double bias_share = 0;    ///< of the time, within such runs

  /// Share of those in the map.
  double wrong_share() const { return used > 0 ? double(wrong) / double(used) : 0; }
};

/// A false fix does not end a run. Between two fixes of different kind a run ends halfway.
/// Intervals of more than a minute without fixes end a run and do not count: errors are forgotten
/// by then.
FixFigures fix_figures(const MapResult& result);

/// The worse verdict on the shares of false and of biased fixes; not judged where they are few, or
/// taken without modes.
HealthVerdict verdict_on_fixes(const FixFigures& fixes);

}  // namespace hybrid
