// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, the hybrid mapping authors
#pragma once

#include <cstdint>
#include <optional>
#include <vector>

#include "libhybrid/core/values.h"
#include "libhybrid/geometry/se2.h"
#include "libhybrid/hybrid/hybrid_factor.h"

namespace hybrid {

/// The motion that a value of a choice (a hybrid factor of one discrete variable) measures, if it
/// is from a planar pose to the next.
std::optional<SE2> motion_of(const HybridFactor& choice, int value);

/// Rigid motions of all poses behind choices when their values change. If a choice alone connects
/// the poses behind it with those before it, no residual changes.
class SegmentTransforms {
 public:
  /// Adds the transform by a new value of a choice. `values` holds the poses before any transform;
  /// choices come in the order of their poses.
  void add(const HybridFactor& choice, int value, const Values& values);

  /// A pose after all transforms; they move those from the end of a choice on.
  SE2 operator()(Key key, const SE2& pose) const;

 private:
  struct Transform {
    std::uint64_t from;  // index of the first pose that moves
    SE2 motion;          // in the map, all transforms before it included
  };
  std::vector<Transform> transforms_;
};

}  // namespace hybrid
