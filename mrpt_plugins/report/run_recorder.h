// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, the hybrid mapping authors

#pragma once

#include <cstddef>
#include <cstdint>
#include <functional>
#include <map>
#include <nlohmann/json_fwd.hpp>
#include <string>
#include <unordered_map>
#include <utility>
#include <vector>

#include "mrpt_plugins/mapping/map_result.h"
#include "mrpt_plugins/mapping/mapper.h"
#include "mrpt_plugins/report/run_record.h"

namespace HYBRID_API hybrid {

/// Keeps the history of a run as it happens, and tells each event at once. The mapper must keep
/// events; the estimate is only read.
class RunRecorder {
 public:
  /// An event as a line of events.jsonl, see docs/events.md.
  using Line = std::function<void(const nlohmann::ordered_json&)>;

  /// `line` hears every event; empty: none. Without `snapshots`, none are kept.
  RunRecorder(Line line, bool snapshots) : line_(std::move(line)), snapshots_(snapshots) {}

  /// The first line. `dimension` is 2 or 3; `robots` are their names, none of one without a name.
  void begin(const std::string& version, const std::string& title, int dimension,
             const std::vector<std::string>& robots);
  /// After each keyframe.
  void keyframe(Mapper& mapper, const StepRecord& step);
  /// After the last one, once the mapper has solved to convergence; `result` is its.
  void finish(Mapper& mapper, const MapResult& result, double objective);

  const RunRecord& record() const { return record_; }

 private:
  void write(const nlohmann::ordered_json& line) const;
  void add(const MapChange& change);
  void add(const SightingEvent& event);
  void add(const AssociationEvent& event);
  void add(const DecisionEvent& event);
  void add(const MergeEvent& event);
  void assign(std::size_t sighting, std::optional<std::int64_t> landmark);
  void write_class_names(const std::vector<std::string>& names);
  void add_class_evidence(const RunRecord::Sighting& sighting, double sign);
  void update_beliefs();
  void add_belief(std::int64_t landmark, const std::vector<double>& probabilities);
  void compute_residuals(const Mapper& mapper);
  void add_snapshot(const Mapper& mapper, int keyframe);
  std::size_t number(std::int64_t of_plugin) const { return numbers_.at(of_plugin); }

  Line line_;
  bool snapshots_;
  RunRecord record_;
  int keyframe_ = 0;
  int every_ = 1;                                          // keyframes from snapshot to snapshot
  std::unordered_map<std::int64_t, std::size_t> numbers_;  // of sightings, by those of the plugin
  std::map<std::int64_t, std::vector<std::size_t>> seen_;  // sightings of each landmark
  std::vector<std::int64_t> touched_;                      // landmarks with news of their class
  std::vector<std::string> class_names_;
  std::vector<double> class_prior_;
  std::map<std::int64_t, std::vector<double>> class_evidence_;  // sums of logarithms
};

}  // namespace hybrid
