// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, the hybrid mapping authors

#include "libhybrid/online/closure_graph.h"

#include <memory>

#include "libhybrid/core/key_letters.h"
#include "libhybrid/factors/prior.h"

namespace hybrid {
namespace {

/// Poses that tell how far the path spreads, evenly chosen: a budget of time.
constexpr std::size_t kMostPositions = 1000;

Key key_of_pose(std::size_t i) {
  return {key_letter::kPose, i};
}

template <class Pose>
ContinuousFactorPtr motion_between(Key from, Key to, const Uncertain<Pose>& measured) {
  return std::make_shared<Between<Pose>>(from, to, measured.motion,
                                         Noise::covariance(measured.covariance));
}

}  // namespace

template <class Pose>
void ClosureGraph<Pose>::adopt(std::vector<KnownPlace<Pose>> places, const Uncertain<Pose>& start) {
  places_ = std::move(places);
  start_ = start;
}

template <class Pose>
void ClosureGraph<Pose>::begin() {
  Delta change;
  const Key first = key_of_pose(0);
  change.values.insert(first, start_.motion);
  change.continuous.push_back(
      std::make_shared<Prior<Pose>>(first, start_.motion, Noise::covariance(start_.covariance)));
  selection_.update(change);
}

template <class Pose>
Delta ClosureGraph<Pose>::step(std::size_t next, const Pose& initial,
                               const std::vector<Motion>& motions) const {
  Delta change;
  change.values.insert(key_of_pose(next), initial);
  for (const Motion& motion : motions) {
    change.continuous.push_back(
        motion_between(key_of_pose(motion.from), key_of_pose(next), motion.measured));
  }
  return change;
}

/// Covariance of the way from any pose or known place to any other, in the frame of the map [m^2].
template <class Pose>
typename SurfaceMatch<Pose>::Spread ClosureGraph<Pose>::spread(std::size_t poses) const {
  std::vector<typename SurfaceMatch<Pose>::Position> positions;
  const std::size_t stride = 1 + poses / kMostPositions;
  for (std::size_t i = 0; i < poses; i += stride) positions.push_back(pose(i).translation());
  for (const KnownPlace<Pose>& place : places_) positions.push_back(place.motion.translation());
  typename SurfaceMatch<Pose>::Position mean = SurfaceMatch<Pose>::Position::Zero();
  for (const auto& position : positions) mean += position / double(positions.size());
  typename SurfaceMatch<Pose>::Spread sum = SurfaceMatch<Pose>::Spread::Zero();
  for (const auto& position : positions) sum += (position - mean) * (position - mean).transpose();
  return 2.0 / double(positions.size()) * sum;
}

/// Known places become variables with their first closures.
template <class Pose>
void ClosureGraph<Pose>::add(Delta change, const std::vector<PlaceClosure<Pose>>& found) {
  std::vector<ContinuousFactorPtr> factors;
  Alternatives modes;
  typename SurfaceMatch<Pose>::Spread spread;
  if (!found.empty()) spread = this->spread(found.front().to);
  for (const PlaceClosure<Pose>& closure : found) {
    const Key from = closure.is_known ? place_key(closure.from) : key_of_pose(closure.from);
    if (closure.is_known) {
      insert_place(places_, closure.from, selection_.smoother().values(), change);
    }
    modes.add(closure.first_mode);
    const Key to = key_of_pose(closure.to);
    const auto& values =
        change.values.contains(to) ? change.values : selection_.smoother().values();
    const auto R = values.template at<Pose>(to).rotation().matrix();
    factors.push_back(std::make_shared<SurfaceMatch<Pose>>(
        from, to, closure.pose.motion, Noise::covariance(closure.pose.covariance),
        R.transpose() * spread * R));
  }
  closures_.reserve(closures_.size() + found.size());
  selection_.update(change, factors, modes);
  closures_.insert(closures_.end(), found.begin(), found.end());
}

template <class Pose>
Pose ClosureGraph<Pose>::pose(std::size_t i) const {
  return selection_.smoother().values().template at<Pose>(key_of_pose(i));
}

template <class Pose>
Uncertain<Pose> ClosureGraph<Pose>::relation(std::size_t a, std::size_t b) const {
  if (a == b) return {Pose(), Pose::Jacobian::Zero()};
  return relation_of<Pose>(key_of_pose(a), key_of_pose(b), selection_.smoother());
}

template <class Pose>
Uncertain<Pose> ClosureGraph<Pose>::from_place(std::size_t place, std::size_t pose) const {
  return relation_to_place<Pose>(places_, place, key_of_pose(pose), selection_.smoother());
}

template class ClosureGraph<SE2>;
template class ClosureGraph<SE3>;

}  // namespace hybrid
