// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, the hybrid mapping authors

#pragma once

#include <memory>
#include <nlohmann/json_fwd.hpp>
#include <optional>
#include <string>
#include <vector>

#include "libhybrid/io/file_writer.h"
#include "mrpt_plugins/bridge/output_directory.h"
#include "mrpt_plugins/mapping/mapper.h"
#include "mrpt_plugins/output/scan_map.h"
#include "mrpt_plugins/report/keyframe_lines.h"
#include "mrpt_plugins/report/photographs.h"
#include "mrpt_plugins/report/run_recorder.h"
#include "mrpt_plugins/session/truth.h"
#include "mrpt_plugins/settings/replay_request.h"

namespace hybrid {

/// What a replay tells of its way, where it is asked to: keyframes and events.jsonl as it goes, and
/// report.html.
class RunReport {
 public:
  /// Asked for by `request`; `out` must live as long as this.
  RunReport(const ReplayRequest& request, const ReplaySettings& settings,
            const OutputDirectory& out);

  /// Before the first keyframe.
  void begin(Mapper& mapper, const std::string& title);
  /// Whether keyframes are asked for as lines.
  bool has_lines() const { return lines_.has_value(); }
  /// After every keyframe; returns it as a line of JSON, "" where none is asked for, with what was
  /// found of the agreement over time.
  std::string watch(Mapper& mapper, const StepRecord& step, const Keyframe& keyframe,
                    const std::optional<Health>& agreement);
  /// Once the mapper has solved to convergence; closes events.jsonl.
  void finish(Mapper& mapper, const MapResult& result, double objective);

  /// Writes report.html, where that is asked for, with these scans, or what clouds saw.
  void write(const MapResult& result, const std::vector<RobotPart>& parts,
             const std::vector<Truth>& truths, const std::vector<KeyframeScans>& scans,
             const std::vector<LocalView>& views, const nlohmann::ordered_json& summary) const;

 private:
  std::string version_;
  bool page_ = false;
  std::optional<KeyframeLines> lines_;  // where they are asked for
  const OutputDirectory& out_;
  std::unique_ptr<FileWriter> events_;
  std::optional<RunRecorder> recorder_;  // where anything is asked for
  std::vector<std::string> rawlogs_;     // of the robots
  Photographs photographs_;
};

}  // namespace hybrid
