// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, the hybrid mapping authors

#pragma once

#include <functional>
#include <limits>

#include "mrpt_plugins/session/judgement.h"
#include "mrpt_plugins/settings/replay_settings.h"

namespace HYBRID_API hybrid {

/// When a map of the logs is not the one to write.
struct Conditions {
  const Health* other = nullptr;  ///< of a map that this one has to be better than,
  std::function<bool(const Health&, const Health&)> better = is_better;  ///< in this sense
  bool corrected = false;   ///< it is made only if something of the logs is corrected,
  bool aligned = false;     ///< which is more than noise
  bool had_no_ids = false;  ///< ids were hidden already in the map before
  /// It is given up once it has taken more (Mapper::work).
  double most_work = std::numeric_limits<double>::infinity();

  /// Whether these settings may give another map at all.
  bool allow(const ReplaySettings& settings) const;
  /// Whether a map that says this of itself is the one to write; `signal` is what stopped it, or 0.
  bool want(const Health& health, int signal) const;
};

/// Whether the logs were measured, and all is used as they state it, but for ids that were hidden
/// before.
bool is_as_stated(const ReplaySettings& settings, bool had_no_ids);

/// Whether noise, clock and mounting are to be measured where the map is bad: logs can be read
/// twice, and nothing but the output folder holds what was mapped.
bool may_measure(const ReplayRequest& request, const ReplaySettings& settings);

}  // namespace hybrid
