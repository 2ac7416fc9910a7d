// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, the hybrid mapping authors

#pragma once

#include <cmath>

namespace hybrid {

/// The time [s] that a log has for this one: its stamps count 100 ns. Times that are compared or
/// made of others are rounded to it first, so that no two of them become one stamp.
inline double log_time(double time) {
  constexpr double kStamps = 1e7;  // in a second
  return std::round(time * kStamps) / kStamps;
}

}  // namespace hybrid
