// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, the hybrid mapping authors
#pragma once

#include <string>
#include <vector>

#include "mrpt_plugins/health/health.h"

namespace HYBRID_API hybrid {

/// What a result says against itself, for the console: a line for each verdict that is bad, and one
/// line that names all that are doubtful, with their values and limits.
std::vector<std::string> health_lines(const Health& health);

}  // namespace hybrid
