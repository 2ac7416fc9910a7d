// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, the hybrid mapping authors

#pragma once

#include <string>

#include "apps/hybrid-experiment/options.h"
#include "mrpt_plugins/experiment/ranks.h"

namespace hybrid {

/// Runs the trials without a result, on other ranks if there are any, then writes summaries and
/// plots. Returns the exit code; throws on failure.
int run_experiment(const Options& options, Channel* ranks);

/// Runs the trials that rank 0 hands out. Returns the exit code.
int serve_experiment(const Options& options, Channel& ranks);

/// All sections and keys as a commented INI: with the values of the given INI, or the defaults.
std::string config_text(const Options& options);

}  // namespace hybrid
