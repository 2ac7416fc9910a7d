// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, the hybrid mapping authors

#pragma once

#include "apps/hybrid-register/options.h"

namespace hybrid {

/// Reads both clouds, registers them, writes the results and prints a summary. Returns the exit
/// code. Throws on failure.
int run(const Options& options);

}  // namespace hybrid
