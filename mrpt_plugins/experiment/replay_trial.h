// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, the hybrid mapping authors

#pragma once

#include <filesystem>

#include "mrpt_plugins/bridge/provenance.h"
#include "mrpt_plugins/experiment/ledger.h"
#include "mrpt_plugins/experiment/plan.h"

namespace HYBRID_API hybrid {

/// Names of what a replay measures: seconds (of the solver), total_s, keyframes, landmarks, and the
/// fields of summary.json that the plan names, by their paths, e.g. truth.trajectory.rmse_m.
std::vector<std::string> replay_metrics(const ExperimentPlan& plan);

/// Simulates a log where the plan says so, and replays it into a folder of the trial's own below
/// `output`; `provenance` is that of the experiment. Throws Error where one of them fails,
/// MachineFault where the machine is to blame.
TrialResult run_replay_trial(const ExperimentPlan& plan, const Trial& trial,
                             const Provenance& provenance, const std::filesystem::path& output);

}  // namespace hybrid
