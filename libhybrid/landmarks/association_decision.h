// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, the hybrid mapping authors

#pragma once

#include <cstddef>
#include <cstdint>
#include <optional>

#include "libhybrid/export.h"

namespace HYBRID_API hybrid {

/// What one measurement was attributed to and what it really came from. No estimated id: it was
/// taken for clutter. No true id: clutter, or nobody knows.
struct AssociationDecision {
  std::optional<std::int64_t> estimated_id;
  std::optional<std::int64_t> true_id;
  /// Which measurement it was, where a file may tell the true id: number of the pose, and number
  /// among the measurements made there.
  std::size_t pose = 0, measurement = 0;
  std::optional<std::int64_t> mover = std::nullopt;  ///< the thing that it is of, if that moves
};

}  // namespace hybrid
