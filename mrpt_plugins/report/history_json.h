// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, the hybrid mapping authors

#pragma once

#include <nlohmann/json_fwd.hpp>

#include "mrpt_plugins/report/run_record.h"

namespace HYBRID_API hybrid {

/// The history of a run for the page: sightings, associations, decisions, merges, changes, beliefs,
/// births and removals, and snapshots of the estimate. web/src/data.ts has the types.
nlohmann::ordered_json history_json(const RunRecord& record, bool is_3d);

}  // namespace hybrid
