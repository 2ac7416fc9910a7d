// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, the hybrid mapping authors

#pragma once

#include <nlohmann/json_fwd.hpp>
#include <vector>

#include "mrpt_plugins/evaluation/trajectory_metrics.h"
#include "mrpt_plugins/mapping/map_result.h"
#include "mrpt_plugins/report/run_record.h"

namespace hybrid {

/// A replay as its report shows it.
struct MapReport {
  const MapResult& result;
  const GroundTruth& truth;
  const RunRecord& record;
  const nlohmann::ordered_json& photographs;  ///< of Photographs
  const nlohmann::ordered_json& summary;      ///< the content of summary.json
  std::vector<double> times;                  ///< of the pairs [s]
  std::vector<PosePair> estimated, reckoned;  ///< with the truth; empty where that is not known
};

/// The data of the page.
nlohmann::ordered_json map_report_json(const MapReport& report);

}  // namespace hybrid
