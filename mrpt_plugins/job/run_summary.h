// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, the hybrid mapping authors

#pragma once

#include <string>
#include <vector>

#include "mrpt_plugins/output/summary.h"
#include "mrpt_plugins/session/session.h"

namespace HYBRID_API hybrid {

/// Adds warnings to a summary.
void warn(Summary& summary, const std::vector<std::string>& more);

/// Adds what was measured of the logs before they were mapped.
void tell_findings(const ReplaySettings& settings, Summary& summary);

/// Adds that what was measured of the logs is no noise of a sensor, where it is not.
void judge_findings(const ReplaySettings& settings, Health& health);

/// What a finished run says, apart from truth, robots and files.
Summary summarize(const Session& session, const MapResult& result);

}  // namespace hybrid
