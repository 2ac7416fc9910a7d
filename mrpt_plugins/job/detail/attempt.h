// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, the hybrid mapping authors

#pragma once

#include <chrono>
#include <functional>

#include "mrpt_plugins/job/replay_outcome.h"
#include "mrpt_plugins/session/conditions.h"
#include "mrpt_plugins/settings/replay_request.h"

namespace hybrid {

/// What to tell of a replay while it runs.
struct Watchers {
  const std::function<void(const ReplayProgress&)>& progress;
  const std::function<void(const ReplayOutcome&)>& published;
};

/// One map of the logs, which was written unless it is no better than another.
struct Attempt {
  ReplayRequest request;
  ReplayOutcome outcome;
  bool is_written = true;
  bool may_measure = false;       ///< the logs can be measured, and mapped again
  bool had_no_ids = false;        ///< ids of a log were hidden
  bool measured_nothing = false;  ///< the logs were measured and are as they state
  double work = 0;                ///< what it took (Mapper::work)
};

/// Maps the logs, and writes the result where the conditions hold.
Attempt attempt(const ReplayRequest& request, const Watchers& watchers,
                std::chrono::steady_clock::time_point start, const Conditions& conditions);

}  // namespace hybrid
