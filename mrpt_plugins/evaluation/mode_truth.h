// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, the hybrid mapping authors

#pragma once

#include <string>
#include <vector>

#include "libhybrid/export.h"

namespace HYBRID_API hybrid {

/// True modes of motion, one whole number per row: row i has the mode of the motion to step i of
/// the log. Empty lines and comments (`%` or `#`) are skipped. Throws Error with file:line for
/// anything else, and for a file without rows.
std::vector<int> read_true_modes(const std::string& path);

}  // namespace hybrid
