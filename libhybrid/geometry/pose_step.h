// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, the hybrid mapping authors
#pragma once

#include <Eigen/Core>
#include <type_traits>

#include "libhybrid/geometry/se2.h"
#include "libhybrid/geometry/se3.h"

namespace HYBRID_API hybrid {

/// A pose after a step in its own frame: moved along the tangent, as points are, and turned by Exp.
template <class Pose>
Pose tangent_step(const Pose& from, const typename Pose::Tangent& v) {
  using Rotation = std::decay_t<decltype(from.rotation())>;
  return {from.translation() + from.rotation() * v.template head<Pose::kDim - Rotation::kDim>(),
          from.rotation() * Rotation::exp(v.template tail<Rotation::kDim>())};
}

/// The step that leads over a motion: tangent_step(from, v) is from * motion.
template <class Pose>
typename Pose::Tangent tangent_step_of(const Pose& motion) {
  typename Pose::Tangent v;
  v << motion.translation(), motion.rotation().log();
  return v;
}

/// The step of a pose over a motion: along the arc of Exp, or beside points along the tangent, as
/// they step. Along an arc a pose would part from the points about it by half the turn for each
/// metre of its way.
template <class Pose>
typename Pose::Tangent step_over(const Pose& motion, bool beside_points) {
  return beside_points ? tangent_step_of(motion) : motion.log();
}

/// Where such a step leads.
template <class Pose>
Pose after_step(const Pose& from, const double* step, bool beside_points) {
  const typename Pose::Tangent v = Eigen::Map<const typename Pose::Tangent>(step);
  return beside_points ? tangent_step(from, v) : from * Pose::exp(v);
}

}  // namespace hybrid
