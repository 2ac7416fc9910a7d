// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, the hybrid mapping authors

#pragma once

#include <cstddef>
#include <cstdint>
#include <map>
#include <string>
#include <utility>

#include "libhybrid/export.h"

namespace HYBRID_API hybrid {

/// True landmark ids of measurements without an id: (step of the log, index of the measurement in
/// it) -> true id.
using AssociationTruth = std::map<std::pair<std::size_t, std::size_t>, std::int64_t>;

/// Reads `step,measurement,true_id`, as the importers write it. Throws Error with file:line for
/// anything else, and for a measurement that is named twice.
AssociationTruth read_true_associations(const std::string& path);

}  // namespace hybrid
