// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, the hybrid mapping authors

#include "mrpt_plugins/input/log_merge.h"

#include <algorithm>
#include <utility>

#include "libhybrid/core/error.h"

namespace hybrid {
namespace {

void add_to(DropReport& all, const DropReport& more) {
  for (const auto& [what, count] : more) all[what] += count;
}

}  // namespace

void LogMerge::add(const std::string& name, const std::string& rawlog,
                   const SourceOptions& options) {
  logs_.push_back({name, std::make_unique<KeyframeSource>(rawlog, options), std::nullopt, false});
}

bool LogMerge::begins() {
  bool any = false;
  for (Log& log : logs_) {
    if (!log.ahead && !log.ended) {
      log.ahead = log.source->next();
      log.ended = !log.ahead;
    }
    any = any || log.ahead;
  }
  return any;
}

std::optional<Keyframe> LogMerge::next() {
  if (!begins()) return std::nullopt;
  Log* earliest = nullptr;
  for (Log& log : logs_) {
    if (!log.ahead) continue;
    if (earliest == nullptr || log.ahead->time < earliest->ahead->time) earliest = &log;
  }
  std::optional<Keyframe> out = std::exchange(earliest->ahead, std::nullopt);
  out->robot = static_cast<std::size_t>(earliest - logs_.data());
  return out;
}

std::vector<PoseBetween> LogMerge::rest(std::size_t robot) const {
  const Log& log = logs_[robot];
  return log.ended ? log.source->rest() : std::vector<PoseBetween>();
}

bool LogMerge::is_3d() {
  for (Log& log : logs_) {
    if (log.source->is_3d() == logs_.front().source->is_3d()) continue;
    throw Error("the log of robot " + log.name + " is of another dimension than that of robot " +
                logs_.front().name + "; [map] dimension says which the map is to have");
  }
  return logs_.front().source->is_3d();
}

const KeyframeSource& LogMerge::worst() const {
  for (const Log& log : logs_) {
    if (log.source->status() != LogStatus::kComplete) return *log.source;
  }
  return *logs_.front().source;
}

LogStatus LogMerge::status() const {
  return worst().status();
}

const std::string& LogMerge::message() const {
  return worst().message();
}

std::optional<double> LogMerge::progress() const {
  double sum = 0;
  for (const Log& log : logs_) {
    const std::optional<double> share = log.source->progress();
    if (!share) return std::nullopt;
    sum += *share;
  }
  return sum / static_cast<double>(logs_.size());
}

DropReport LogMerge::dropped() const {
  DropReport all;
  for (const Log& log : logs_) add_to(all, log.source->dropped());
  return all;
}

std::map<std::string, std::size_t> LogMerge::observations() const {
  std::map<std::string, std::size_t> all;
  for (const Log& log : logs_) add_to(all, log.source->observations());
  return all;
}

double LogMerge::repeated_stamps() const {
  double most = 0.0;
  for (const Log& log : logs_) most = std::max(most, log.source->repeated_stamps());
  return most;
}

std::size_t LogMerge::odometry_stops() const {
  std::size_t sum = 0;
  for (const Log& log : logs_) sum += log.source->odometry_stops();
  return sum;
}

DropReport LogMerge::warnings() const {
  DropReport all;
  for (const Log& log : logs_) add_to(all, log.source->warnings());
  return all;
}

}  // namespace hybrid
