// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, the hybrid mapping authors

#pragma once

#include <nlohmann/json_fwd.hpp>

#include "mrpt_plugins/health/health.h"

namespace HYBRID_API hybrid {

/// The entries as summary.json and the lines of --stream have them. Limits that are infinite, and a
/// value that is not judged, become null.
nlohmann::ordered_json health_json(const Health& health);

}  // namespace hybrid
