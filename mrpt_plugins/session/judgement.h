// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, the hybrid mapping authors

#pragma once

#include <cstddef>

#include "mrpt_plugins/health/health.h"
#include "mrpt_plugins/input/log_merge.h"
#include "mrpt_plugins/mapping/mapper.h"
#include "mrpt_plugins/settings/replay_settings.h"

namespace HYBRID_API hybrid {

/// What a map says about itself. If the request asks for it, every other detection is mapped apart
/// from the rest, and both paths are compared; `settings` chose the plugins. It begins with the
/// `agreement` over time, which other checks ask. Throws Error where a log can be read but once.
Health judge_run(const ReplayRequest& request, const ReplaySettings& settings, const LogMerge& log,
                 const Mapper& mapper, const MapResult& result, Health agreement);

/// How many checks of a map are judged, but for those of what is estimated only where that is
/// asked.
std::ptrdiff_t count_judged(const Health& health);

/// Whether a map says less against itself than another, and nothing worse: fewer checks are bad, or
/// where none of the other's is bad, fewer are doubtful. One that fewer checks ask of is not.
bool is_better(const Health& a, const Health& b);

}  // namespace hybrid
