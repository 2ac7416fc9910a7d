// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, the hybrid mapping authors

#pragma once

#include <nlohmann/json_fwd.hpp>

#include "mrpt_plugins/mapping/map_result.h"

namespace HYBRID_API hybrid {

/// Fixes as columns: keyframe, where the receiver says that it is and where the map says that the
/// antenna is [m], mode (0: good, 1: biased, 2: false, 3: not in the map), and probabilities of the
/// first three where they are known. Of each mode at most `most` are kept, every n-th. Empty where
/// it is not known where fixes are in the map.
nlohmann::ordered_json fixes_json(const MapResult& result, std::size_t most = 2000);

}  // namespace hybrid
