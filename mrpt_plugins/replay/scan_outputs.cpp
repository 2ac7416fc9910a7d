// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, the hybrid mapping authors

#include "mrpt_plugins/replay/detail/scan_outputs.h"

#include <fmt/format.h>

#include <memory>

namespace hybrid {

ScanOutputs::ScanOutputs(const ReplaySettings& settings) {
  if (settings.keeps_scans) archive_.emplace();
}

void ScanOutputs::added(const StepRecord& step, const Keyframe& keyframe) {
  if (archive_) archive_->add(static_cast<std::size_t>(step.keyframe), keyframe);
}

void ScanOutputs::finish(MapResult& result) {
  if (!archive_) return;
  drawn_ = drawn_keyframes(*archive_, result.trajectory);
  GridMap grid = draw_grid(drawn_, result.trajectory);
  if (!grid.empty()) result.grid = std::make_shared<const GridMap>(std::move(grid));
}

std::vector<std::string> ScanOutputs::write(const OutputDirectory& out, const MapResult& result,
                                            const Mapper& mapper) const {
  std::vector<std::string> warnings;
  if (!result.grid) return warnings;
  out.write("map.pgm", grid_pgm(*result.grid));
  out.write("map.yaml", grid_yaml(*result.grid, "map.pgm"));
  write_simple_map(out, "map.simplemap", drawn_, result.trajectory, mapper.pose_covariances());
  if (archive_->given_up() > 0) {
    warnings.push_back(
        fmt::format("the log holds more scans than fit into {} MiB: {} of them are in the "
                    "trajectory and not in map.pgm, map.png and map.simplemap",
                    ScanArchive::kBudget >> 20, archive_->given_up()));
  }
  return warnings;
}

Trajectory ScanOutputs::path(const RobotPart& part, const MapResult& whole,
                             std::size_t robot) const {
  return archive_ ? archive_->path(whole.trajectory, robot) : part.result.trajectory;
}

}  // namespace hybrid
