// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, the hybrid mapping authors
#pragma once

namespace hybrid {

/// Observations that what is assumed of a sensor before any counts as much as: of its noise, of
/// what it has in view, of how often it detects a landmark.
inline constexpr double kPriorCount = 10.0;

}  // namespace hybrid
