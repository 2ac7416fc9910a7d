// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, the hybrid mapping authors

#pragma once

#include <cstddef>
#include <optional>
#include <utility>

#include "libhybrid/geometry/uncertain_motion.h"

namespace HYBRID_API hybrid {

/// How well a place is known beside another one, which stands before it in a list of places.
template <class Pose>
struct PlaceParent {
  std::size_t place = 0;
  typename Pose::Jacobian covariance;  ///< of the pose in the frame of `place`, in its tangent
};

/// A place of an earlier map in the frame of that. Places that follow each other have most of their
/// errors in common, so that all but the first are known best beside one that comes before. Their
/// joint density is the product of these: that of each place alone is as it stands here.
template <class Pose>
struct KnownPlace : Uncertain<Pose> {
  KnownPlace() = default;
  KnownPlace(const Uncertain<Pose>& place) : Uncertain<Pose>(place) {}  // NOLINT
  KnownPlace(const Pose& motion, const typename Pose::Jacobian& covariance)
      : Uncertain<Pose>{motion, covariance} {}

  std::optional<PlaceParent<Pose>> parent;  ///< nothing: known beside no other
};

}  // namespace hybrid
