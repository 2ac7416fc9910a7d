// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, the hybrid mapping authors

#pragma once

#include <cstdint>
#include <map>
#include <optional>
#include <string>

#include "mrpt_plugins/health/health.h"
#include "mrpt_plugins/mapping/mapper.h"

namespace HYBRID_API hybrid {

/// A run as lines of JSON, one for each keyframe, see docs/events.md: its pose, and what is new of
/// the landmarks since the line before. Whoever applies all lines has the map.
class KeyframeLines {
 public:
  /// The line of the newest keyframe, without an end of line; with the entries of the agreement
  /// over time, where it was asked.
  std::string line(const Mapper& mapper, const StepRecord& step,
                   const std::optional<Health>& agreement);

 private:
  std::map<std::int64_t, std::string> told_;  // landmarks as the lines before have them
};

}  // namespace hybrid
