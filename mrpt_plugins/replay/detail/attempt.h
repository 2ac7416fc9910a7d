// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, the hybrid mapping authors

#pragma once

#include <chrono>
#include <functional>

#include "mrpt_plugins/health/health.h"
#include "mrpt_plugins/replay/detail/judgement.h"
#include "mrpt_plugins/replay/replay.h"

namespace hybrid {

/// What to tell of a replay while it runs.
struct Watchers {
  const std::function<void(const ReplayProgress&)>& progress;
  const std::function<void(const ReplayOutcome&)>& published;
};

/// One map of the logs, which was written unless it is no better than another.
struct Attempt {
  ReplayOutcome outcome;
  bool is_written = true;
  bool may_measure = false;  ///< the logs can be measured, and mapped again
};

/// When a map of the logs is not the one to write.
struct Conditions {
  const Health* other = nullptr;  ///< of a map that this one has to be better than,
  std::function<bool(const Health&, const Health&)> better = is_better;  ///< in this sense
  bool corrected = false;  ///< it is made only if something of the logs is corrected,
  bool aligned = false;    ///< which is more than noise
};

/// Maps the logs, and writes the result where the conditions hold.
Attempt attempt(const ReplayRequest& request, const Watchers& watchers,
                std::chrono::steady_clock::time_point start, const Conditions& conditions);

}  // namespace hybrid
