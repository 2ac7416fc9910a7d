// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, the hybrid mapping authors

#pragma once

#include <nlohmann/json_fwd.hpp>
#include <string>
#include <vector>

#include "mrpt_plugins/evaluation/trajectory_metrics.h"
#include "mrpt_plugins/mapping/map_result.h"
#include "mrpt_plugins/output/scan_map.h"
#include "mrpt_plugins/report/run_record.h"

namespace HYBRID_API hybrid {

/// The poses of a robot with the true ones of the same instants.
struct PathPairs {
  std::string robot;                          ///< empty where there is but one
  std::vector<double> times;                  ///< [s]
  std::vector<PosePair> estimated, reckoned;  ///< by all measurements, and by odometry alone
};

/// A replay as its report shows it.
struct MapReport {
  const MapResult& result;
  const GroundTruth& truth;
  const RunRecord& record;
  const nlohmann::ordered_json& photographs;  ///< of Photographs
  const nlohmann::ordered_json& summary;      ///< the content of summary.json
  const std::vector<KeyframeScans>& scans;    ///< of the keyframes that a map is drawn of
  const std::vector<LocalView>& views;        ///< what clouds saw, in place of scans
  std::vector<PathPairs> paths;               ///< of the robots whose true path is known
};

/// The data of the page.
nlohmann::ordered_json map_report_json(const MapReport& report);

}  // namespace hybrid
