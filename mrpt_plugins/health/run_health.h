// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, the hybrid mapping authors

#pragma once

#include <cstddef>
#include <map>
#include <string>

#include "libhybrid/hybrid/graph.h"
#include "mrpt_plugins/health/health.h"
#include "mrpt_plugins/mapping/map_result.h"

namespace HYBRID_API hybrid {

/// What a finished run has to judge itself by.
struct RunToJudge {
  const HybridGraph& graph;
  const Estimate& estimate;
  const MapResult& result;
  /// Reason -> number of measurements that were not used.
  const std::map<std::string, std::size_t>& dropped;
  /// Detections of which the mapping decided what they are of, also those that have left the graph.
  std::size_t decided = 0;
  /// Figures of the plugins (MappingPlugin::statistics).
  std::map<std::string, double> statistics = {};
  /// What was measured far apart in time agrees in space.
  bool agrees = false;

  /// Whether the mapping decided which detection is of which landmark.
  bool associates() const { return decided > 0; }
};

/// All that a run tells about itself without truth; quantities that it has no basis for are left
/// out. The estimate is not changed; the cost is that of one factorisation and some hundred
/// covariances.
Health run_health(const RunToJudge& run);

}  // namespace hybrid
