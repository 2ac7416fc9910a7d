// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, the hybrid mapping authors

#pragma once

#include <string>

#include "mrpt_plugins/health/health.h"

namespace HYBRID_API hybrid {

/// Residuals that others check less do not tell their noise.
inline constexpr double kLeastRedundancy = 10;

/// An entry, without sentence and knob, about residuals whose scatter is `factor` times what their
/// noise says, where others check so many degrees of freedom of them (at least kLeastRedundancy).
HealthEntry noise_entry(const std::string& name, double factor, double redundancy);

}  // namespace hybrid
