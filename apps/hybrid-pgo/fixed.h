// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, the hybrid mapping authors

#pragma once

#include <vector>

#include "apps/hybrid-pgo/outputs.h"
#include "apps/hybrid-pgo/solution.h"

namespace hybrid {

/// Whether the fixed vertices of a graph agree with the poses and positions measured in the map;
/// empty without both.
Health fixed_health(const Input& input, const std::vector<Loop>& loops);

}  // namespace hybrid
