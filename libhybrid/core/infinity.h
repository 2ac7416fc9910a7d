// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, the hybrid mapping authors
#pragma once

#include <limits>

#include "libhybrid/export.h"

namespace HYBRID_API hybrid {

inline constexpr double kInfinity = std::numeric_limits<double>::infinity();

}  // namespace hybrid
