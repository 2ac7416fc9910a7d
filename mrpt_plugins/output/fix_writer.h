// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, the hybrid mapping authors

#pragma once

#include <string>

#include "mrpt_plugins/mapping/map_result.h"

namespace HYBRID_API hybrid {

/// Name of a mode: "good", "biased" or "false".
std::string to_string(FixMode mode);

/// A row per fix, comma-separated: time [s], keyframe, where the receiver says that it is and where
/// the map says that its antenna is [m, map frame], what it differs by and what of it lasts [m,
/// east, north, up], sigma as stated [m], mode, probabilities of the modes, and why it was not
/// used.
std::string fixes_csv(const MapResult& result);

}  // namespace hybrid
