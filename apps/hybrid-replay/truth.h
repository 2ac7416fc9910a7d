// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, the hybrid mapping authors

#pragma once

#include <string>
#include <vector>

#include "mrpt_plugins/mapping/mapper.h"
#include "mrpt_plugins/output/result.h"
#include "mrpt_plugins/output/summary.h"
#include "mrpt_plugins/output/trajectory_metrics.h"

namespace hybrid {

/// What really was, as far as files tell it.
class Truth {
 public:
  /// Reads the files; an empty name means unknown. Throws Error for a missing or malformed file.
  Truth(const std::string& path_file, const std::string& map_file);

  bool empty() const { return truth_.path.empty() && truth_.landmarks.empty(); }

  /// Moves the truth into the frame of the map, which is that of the first pose, and gives the
  /// landmarks the class indices of the map. Throws Error for a class the map does not know.
  void adapt_to(const MapResult& result, const std::vector<std::size_t>& log_rows);

  const GroundTruth& get() const { return truth_; }

  /// Poses with the true ones of the same instant.
  std::vector<PosePair> pairs(const Trajectory& estimate,
                              const std::vector<std::size_t>& log_rows) const;

 private:
  GroundTruth truth_;
  std::string path_file_, map_file_;
  std::vector<std::string> landmark_classes_;  // one per landmark, empty where unknown
  bool has_times_ = false;                     // TUM; else row i belongs to step i of the log
};

/// All errors of a map against the truth, once that is adapted to it.
TruthSummary compare(const Truth& truth, const MapResult& result, const Mapper& mapper);

}  // namespace hybrid
