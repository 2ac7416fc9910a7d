// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, the hybrid mapping authors
#include "libhybrid/selection/detail/segment_transforms.h"

#include "libhybrid/factors/factor.h"

namespace hybrid {

std::optional<SE2> motion_of(const HybridFactor& choice, int value) {
  if (choice.discrete_keys().size() != 1 || choice.keys().size() != 2 ||
      choice.keys()[1].index() != choice.keys()[0].index() + 1) {
    return std::nullopt;
  }
  Assignment assignment;
  assignment.set(choice.discrete_keys()[0].key, value);
  const ContinuousFactor* component = choice.given(assignment).factor;
  const auto motion = component == nullptr ? std::nullopt : component->relative_pose_2d();
  if (!motion) return std::nullopt;
  return motion->measured;
}

void SegmentTransforms::add(const HybridFactor& choice, int value, const Values& values) {
  const std::optional<SE2> motion = motion_of(choice, value);
  if (!motion) return;
  const SE2 total = transforms_.empty() ? SE2() : transforms_.back().motion;
  const SE2 moved = total * values.at<SE2>(choice.keys()[0]) * *motion;
  const Key behind = choice.keys()[1];
  transforms_.push_back({behind.index(), moved * values.at<SE2>(behind).inverse()});
}

SE2 SegmentTransforms::operator()(Key key, const SE2& pose) const {
  for (auto transform = transforms_.rbegin(); transform != transforms_.rend(); ++transform) {
    if (key.index() >= transform->from) return transform->motion * pose;
  }
  return pose;
}

}  // namespace hybrid
