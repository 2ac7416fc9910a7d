// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, the hybrid mapping authors
#pragma once

#include <cstdint>
#include <optional>
#include <vector>

#include "libhybrid/core/values.h"
#include "libhybrid/geometry/se2.h"
#include "libhybrid/geometry/se3.h"
#include "libhybrid/hybrid/hybrid_factor.h"

namespace hybrid {

/// Whether all values of a hybrid factor of one discrete variable measure the motion from one pose
/// to the next.
bool is_choice_of_step(const HybridFactor& choice);

/// The motion that a value of such a choice measures.
template <class Pose>
Pose motion_of(const HybridFactor& choice, int value);

/// Rigid motions of all poses behind choices when their values change. If a choice alone connects
/// the poses behind it with those before it, no residual changes. Pose is SE2 or SE3.
template <class Pose>
class SegmentTransforms {
 public:
  /// Adds the transform by a new value of a choice. `values` holds the poses before any transform;
  /// choices come in the order of their poses.
  void add(const HybridFactor& choice, int value, const Values& values);

  /// A pose after all transforms; they move those from the end of a choice on.
  Pose operator()(Key key, const Pose& pose) const;

 private:
  struct Transform {
    std::uint64_t from;  // index of the first pose that moves
    Pose motion;         // in the map, all transforms before it included
  };
  std::vector<Transform> transforms_;
};

}  // namespace hybrid
