// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, the hybrid mapping authors

#pragma once

#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "libhybrid/maps/map_record.h"
#include "libhybrid/uncertainty/agreement.h"
#include "mrpt_plugins/bridge/output_directory.h"
#include "mrpt_plugins/input/log_merge.h"
#include "mrpt_plugins/mapping/mapper.h"
#include "mrpt_plugins/mapping/path_archive.h"
#include "mrpt_plugins/mapping/scan_archive.h"
#include "mrpt_plugins/mapping/scan_follower.h"
#include "mrpt_plugins/output/scan_map.h"
#include "mrpt_plugins/session/truth.h"
#include "mrpt_plugins/settings/replay_settings.h"

namespace hybrid {

/// The laser scans of a replay, from its keyframes to map.pgm, map.yaml, map.simplemap, where they
/// are kept; and the paths with a pose for each of these and for each entry of odometry.
class ScanOutputs {
 public:
  ScanOutputs(bool keeps_scans, bool is_3d, std::vector<std::shared_ptr<MappingPlugin>> plugins);

  /// Takes the scans of the newest keyframe of the mapper and what is between it and the one
  /// before, where plugins that follow scans place them, else odometry.
  void added(const StepRecord& step, const Keyframe& keyframe);

  /// Adds the closures by scans and the curves of the paths to the result; after the last keyframe
  /// `source` tells where robots went. Call it once, before the following.
  void finish(const LogMerge& source, MapResult& result);

  /// Draws the grid of the scans with what is in the `known` map that the robots are in, and adds
  /// what clouds saw.
  void draw(MapResult& result, const MapRecord& known) const;

  /// The scans that the grid is drawn of.
  const std::vector<KeyframeScans>& drawn() const { return drawn_; }

  /// The same laid out by the path of all keyframes so far, those of sensors that are level.
  std::vector<PlacedScan> placed(const Mapper& mapper, const Trajectory& keyframes) const;

  /// Writes map.pgm, map.yaml and map.simplemap, where any scan had a return, and loops.csv, where
  /// scans made closures; and the files of clouds. Returns warnings.
  std::vector<std::string> write(const OutputDirectory& out, const MapResult& result,
                                 const Mapper& mapper) const;

  /// Where robots were between keyframes, also while the log runs.
  const PathArchive& paths() const { return paths_; }

 private:
  std::optional<ScanArchive> archive_;
  PathArchive paths_;
  std::vector<std::shared_ptr<MappingPlugin>> plugins_;
  std::vector<KeyframeScans> drawn_;
  std::vector<MeasuredClosure<SE2>> closures_;
};

}  // namespace hybrid
