// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, the hybrid mapping authors

#include "mrpt_plugins/input/log_contents.h"

#include <algorithm>
#include <utility>
#include <vector>

#include "mrpt_plugins/bridge/interrupt.h"

namespace hybrid {
namespace {

void count(const DetectionFrame& frame, LogContents& contents) {
  DetectionCounts& counts = frame.has_range ? contents.with_range : contents.without_range;
  const auto identified =
      std::count_if(frame.detections.begin(), frame.detections.end(),
                    [](const Detection& detection) { return detection.id.has_value(); });
  counts.all += frame.detections.size();
  counts.identified += static_cast<std::size_t>(identified);
  if (!frame.class_names.empty()) counts.classified += frame.detections.size();
}

void add_to(DetectionCounts& all, const DetectionCounts& more) {
  all.all += more.all;
  all.identified += more.identified;
  all.classified += more.classified;
}

}  // namespace

void LogContents::add(const LogContents& other) {
  for (const auto& [name, count] : other.observations) observations[name] += count;
  add_to(with_range, other.with_range);
  add_to(without_range, other.without_range);
  scans += other.scans;
  steps += other.steps;
}

LogContents read_contents(const std::string& rawlog, const SourceOptions& options,
                          const StepWatcher& watcher) {
  LogContents contents;
  RawlogReader reader(rawlog, options.reader);
  DropReport dropped;
  while (const auto step = reader.next()) {
    throw_if_interrupted();
    ++contents.steps;
    std::vector<DetectionFrame> frames;
    for (const auto& observation : step->observations) {
      if (scan_in(*observation, options.scans, dropped)) ++contents.scans;
      auto frame = detections_in(*observation, options.detections, dropped);
      if (!frame) continue;
      count(*frame, contents);
      if (watcher) frames.push_back(std::move(*frame));
    }
    if (watcher) watcher(*step, frames);
  }
  contents.observations = reader.observations();
  return contents;
}

}  // namespace hybrid
