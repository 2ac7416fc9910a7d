// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, the hybrid mapping authors

#pragma once

#include <cstddef>
#include <cstdint>
#include <nlohmann/json_fwd.hpp>
#include <string>
#include <utility>
#include <vector>

#include "libhybrid/closures/closure_decision.h"
#include "libhybrid/geometry/eigen.h"
#include "mrpt_plugins/mapping/map_result.h"

namespace HYBRID_API hybrid {

/// A pose graph as its report shows it. Poses are known by their place in `before`.
struct GraphReport {
  struct Closure {
    std::size_t from = 0, to = 0;
    ClosureDecision decision;
  };
  std::string title;
  bool is_3d = false;
  std::vector<std::uint64_t> ids;                          ///< of the poses
  std::vector<Eigen::Vector3d> before, after;              ///< the poses [m]
  std::vector<Eigen::Vector3d> truth, landmarks;           ///< as far as known
  std::vector<std::pair<std::size_t, std::size_t>> edges;  ///< between neighbours
  std::vector<Closure> closures;
  std::vector<double> objectives;  ///< at the start and after each iteration
  std::vector<StepRecord> steps;   ///< online
};

/// The data of the page; `summary` is the content of summary.json.
nlohmann::ordered_json graph_report_json(const GraphReport& report,
                                         const nlohmann::ordered_json& summary);

/// The same of an experiment; `table` is its results.csv, in which no cell is quoted. Cells that
/// are numbers become numbers.
nlohmann::ordered_json trials_report_json(const std::string& title, const std::string& table,
                                          const nlohmann::ordered_json& summary);

/// Times and flips of the steps as columns.
nlohmann::ordered_json steps_json(const std::vector<StepRecord>& steps);

}  // namespace hybrid
