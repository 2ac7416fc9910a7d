// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, the hybrid mapping authors
#pragma once

#include <cstddef>

namespace hybrid {

/// Closures, landmarks, pairs or matchings that one decision compares at most.
inline constexpr std::size_t kMostCompared = 40;

}  // namespace hybrid
