// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, the hybrid mapping authors

#pragma once

#include <string>

#include "libhybrid/export.h"

namespace HYBRID_API hybrid {

/// Which units differ from metres, or radians, by a ratio or one over it, within a share of 5 %;
/// empty where none does.
std::string length_unit(double ratio);
std::string angle_unit(double ratio);

}  // namespace hybrid
