// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, the hybrid mapping authors

#pragma once

#include <filesystem>

#include "mrpt_plugins/bridge/provenance.h"
#include "mrpt_plugins/experiment/ledger.h"
#include "mrpt_plugins/experiment/plan.h"

namespace HYBRID_API hybrid {

/// Names of the metrics of a replay: seconds (of the solver), total_s, keyframes, landmarks, and
/// the fields of summary.json that the plan names by path, e.g. truth.trajectory.rmse_m.
std::vector<std::string> replay_metrics(const ExperimentPlan& plan);

/// Simulates a log if the plan has a scenario, and replays it into a folder of the trial below
/// `output`. `provenance` is that of the experiment. Throws Error if one of them fails,
/// MachineFault if a fault of the machine is the reason.
TrialResult run_replay_trial(const ExperimentPlan& plan, const Trial& trial,
                             const Provenance& provenance, const std::filesystem::path& output);

}  // namespace hybrid
