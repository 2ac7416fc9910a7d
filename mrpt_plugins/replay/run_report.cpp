// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, the hybrid mapping authors

#include "mrpt_plugins/replay/detail/run_report.h"

#include <nlohmann/json.hpp>
#include <utility>

#include "mrpt_plugins/report/detail/map_report.h"
#include "mrpt_plugins/report/page.h"

namespace hybrid {

RunReport::RunReport(const ReplayRequest& request, const std::string& rawlog,
                     const OutputDirectory& out)
    : version_(request.provenance.version), page_(request.report), out_(out), photographs_(rawlog) {
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
  recorder_->begin(version_, title, mapper.is_3d() ? 3 : 2);
}

std::string RunReport::watch(Mapper& mapper, const StepRecord& step, const Keyframe& keyframe) {
  if (page_) photographs_.add(step.keyframe, keyframe.observations);
  if (recorder_) recorder_->keyframe(mapper, step);
  return lines_ ? lines_->line(mapper, step) : "";
}

void RunReport::finish(Mapper& mapper, const MapResult& result, double objective) {
  if (!recorder_) return;
  recorder_->finish(mapper, result, objective);
  events_->close();
}

void RunReport::write(const MapResult& result, const Truth& truth,
                      const std::vector<std::size_t>& log_rows,
                      const nlohmann::ordered_json& summary) const {
  if (!page_) return;
  const nlohmann::ordered_json photographs = photographs_.json();
  MapReport report{result, truth.get(), recorder_->record(), photographs, summary, {}, {}, {}};
  if (!truth.get().path.empty()) {
    Truth::Pairs pairs = truth.pairs(result.trajectory, log_rows);
    report.times = std::move(pairs.times);
    report.estimated = std::move(pairs.poses);
    report.reckoned = truth.pairs(result.dead_reckoning, log_rows).poses;
  }
  out_.write("report.html", report_page(map_report_json(report)));
}

}  // namespace hybrid
