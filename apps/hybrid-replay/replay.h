// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, the hybrid mapping authors

#pragma once

#include "apps/hybrid-replay/options.h"

namespace hybrid {

/// Runs a whole replay: log in, map out. Returns the exit code; throws on failure.
int replay(const Options& options);

}  // namespace hybrid
