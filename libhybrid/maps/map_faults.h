// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, the hybrid mapping authors

#pragma once

#include <string>
#include <vector>

#include "libhybrid/maps/map_record.h"

namespace HYBRID_API hybrid {

/// What a map cannot be: places beyond the Earth, matrices that are no covariances, probabilities
/// that are none, a prior that contradicts the covariances. Empty where all is well. What is read
/// and written is checked by this alone.
std::vector<std::string> faults_of(const MapRecord& map);

}  // namespace hybrid
