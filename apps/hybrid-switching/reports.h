// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, the hybrid mapping authors

#pragma once

#include "apps/hybrid-switching/options.h"

namespace hybrid {

/// Labels a series fold by fold, scores the labels and writes all outputs. Returns the exit code.
/// Throws Error for bad input.
int report_series(const Options& options);

/// Locates a robot by its ranges, with modes and with robust kernels, compares with the truth if
/// given, and writes all outputs. Returns the exit code. Throws Error for bad input.
int report_ranges(const Options& options);

}  // namespace hybrid
