// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, the hybrid mapping authors

#include "mrpt_plugins/job/detail/run_report.h"

#include <nlohmann/json.hpp>
#include <utility>

#include "mrpt_plugins/report/map_report.h"
#include "mrpt_plugins/report/page.h"

namespace hybrid {

RunReport::RunReport(const ReplayRequest& request, const ReplaySettings& settings,
                     const OutputDirectory& out)
    : version_(request.provenance.version), page_(request.report), out_(out) {
  for (const RobotSettings& robot : settings.robots) rawlogs_.push_back(robot.rawlog);
  if (request.stream) lines_.emplace();
  if (!request.events && !request.report) return;
  events_ = out.open("events.jsonl");
  recorder_.emplace(
      [file = events_.get()](const nlohmann::ordered_json& line) {
        file->write(line.dump(-1, ' ', false, nlohmann::json::error_handler_t::replace) + '\n');
      },
      request.report);
}

void RunReport::begin(Mapper& mapper, const std::string& title) {
  if (!recorder_) return;
  mapper.keep_events();
  recorder_->begin(version_, title, mapper.is_3d() ? 3 : 2, mapper.robot_names());
}

std::string RunReport::watch(Mapper& mapper, const StepRecord& step, const Keyframe& keyframe,
                             const std::optional<Health>& agreement) {
  if (page_) photographs_.add(step.keyframe, keyframe.observations, rawlogs_[keyframe.robot]);
  if (recorder_) recorder_->keyframe(mapper, step);
  return lines_ ? lines_->line(mapper, step, agreement) : "";
}

void RunReport::finish(Mapper& mapper, const MapResult& result, double objective) {
  if (!recorder_) return;
  recorder_->finish(mapper, result, objective);
  events_->close();
}

void RunReport::write(const MapResult& result, const std::vector<RobotPart>& parts,
                      const std::vector<Truth>& truths, const std::vector<KeyframeScans>& scans,
                      const std::vector<LocalView>& views,
                      const nlohmann::ordered_json& summary) const {
  if (!page_) return;
  const nlohmann::ordered_json photographs = photographs_.json();
  const GroundTruth truth = joint_truth(truths);
  MapReport report{result, truth, recorder_->record(), photographs, summary, scans, views, {}};
  for (std::size_t i = 0; i < parts.size(); ++i) {
    const RobotPart& part = parts[i];
    if (truths[i].get().path.empty() || part.result.trajectory.empty()) continue;
    Truth::Pairs pairs = truths[i].pairs(part.result.trajectory, part.log_rows);
    report.paths.push_back({part.name, std::move(pairs.times), std::move(pairs.poses),
                            truths[i].pairs(part.result.dead_reckoning, part.log_rows).poses});
  }
  out_.write("report.html", report_page(map_report_json(report)));
}

}  // namespace hybrid
