// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, the hybrid mapping authors
#include "libhybrid/choices/detail/segment_transforms.h"

#include <string>

#include "libhybrid/core/error.h"
#include "libhybrid/factors/relative_pose.h"

namespace hybrid {
namespace {

template <class Pose>
std::optional<Pose> measured_by(const HybridFactor& choice, int value) {
  Assignment assignment;
  assignment.set(choice.discrete_keys()[0].key, value);
  const ContinuousFactor* component = choice.given(assignment).factor;
  if (component == nullptr || component->keys() != choice.keys()) return std::nullopt;
  const auto motion = relative_pose<Pose>(*component);
  if (!motion) return std::nullopt;
  return motion->measured;
}

}  // namespace

bool is_choice_of_step(const HybridFactor& choice) {
  const std::vector<Key>& keys = choice.keys();
  if (choice.discrete_keys().size() != 1 || keys.size() != 2) return false;
  if (keys[1].letter() != keys[0].letter() || keys[1].index() != keys[0].index() + 1) return false;
  for (int value = 0; value < choice.discrete_keys()[0].cardinality; ++value) {
    if (!measured_by<SE2>(choice, value) && !measured_by<SE3>(choice, value)) return false;
  }
  return true;
}

template <class Pose>
Pose motion_of(const HybridFactor& choice, int value) {
  const std::optional<Pose> motion = measured_by<Pose>(choice, value);
  if (!motion) throw Error("value " + std::to_string(value) + " of a choice measures no motion");
  return *motion;
}

template <class Pose>
void SegmentTransforms<Pose>::add(const HybridFactor& choice, int value, const Values& values) {
  const Pose total = transforms_.empty() ? Pose() : transforms_.back().motion;
  const Pose moved = total * values.at<Pose>(choice.keys()[0]) * motion_of<Pose>(choice, value);
  const Key behind = choice.keys()[1];
  transforms_.push_back({behind.index(), moved * values.at<Pose>(behind).inverse()});
}

template <class Pose>
Pose SegmentTransforms<Pose>::operator()(Key key, const Pose& pose) const {
  for (auto transform = transforms_.rbegin(); transform != transforms_.rend(); ++transform) {
    if (key.index() < transform->from) continue;
    Pose moved = transform->motion * pose;
    moved.normalize();
    return moved;
  }
  return pose;
}

template SE2 motion_of<SE2>(const HybridFactor& choice, int value);
template SE3 motion_of<SE3>(const HybridFactor& choice, int value);
template class SegmentTransforms<SE2>;
template class SegmentTransforms<SE3>;

}  // namespace hybrid
