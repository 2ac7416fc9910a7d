// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, the hybrid mapping authors

#pragma once

#include <filesystem>
#include <functional>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "mrpt_plugins/experiment/ledger.h"
#include "mrpt_plugins/experiment/plan.h"
#include "mrpt_plugins/experiment/pose_graph_trial.h"

namespace hybrid {

/// A result as one line of JSON, and back.
std::string result_text(const TrialResult& result);
TrialResult result_of_text(const std::string& text);

/// Runs trials of a plan, each in a process of its own.
class TrialRunner {
 public:
  using Done = std::function<void(const Trial&, const TrialResult&)>;
  using Stop = std::function<bool()>;

  /// `folder` is where the experiment writes.
  TrialRunner(const ExperimentPlan& plan, const Provenance& provenance,
              std::filesystem::path folder)
      : plan_(plan), provenance_(provenance), folder_(std::move(folder)) {}

  /// Reads the graph of a trial, which stays in memory until that of another is read. One that
  /// cannot be read makes its trials fail.
  void prepare(const Trial& trial);
  /// Runs trials on the prepared graph, `jobs` at a time, until `stop` returns true.
  void run(const std::vector<Trial>& trials, int jobs, const Done& done, const Stop& stop) const;

 private:
  const ExperimentPlan& plan_;
  const Provenance& provenance_;
  std::filesystem::path folder_;
  std::optional<PreparedGraph> graph_;
  std::string fault_;                             // why there is none
  std::pair<std::string, std::string> prepared_;  // graph and variant
};

}  // namespace hybrid
