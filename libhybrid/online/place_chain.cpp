// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, the hybrid mapping authors

#include "libhybrid/online/place_chain.h"

#include <limits>

#include "libhybrid/core/error.h"

namespace hybrid {
namespace {

/// Standard deviation from which on a place is not known beside another [m], [rad].
constexpr double kLeastKnown = 1;

}  // namespace

template <class Pose>
std::optional<PlaceParent<Pose>> PlaceChain<Pose>::next(Key anchor) {
  std::optional<PlaceParent<Pose>> best;
  if (holds_(anchor) && !places_.empty()) {
    for (const std::size_t i : {places_.size() - 1, nearest(anchor)}) {
      if (!places_[i]) continue;
      const auto covariance = covariance_between(*places_[i], anchor);
      if (!covariance || (best && best->covariance.determinant() <= covariance->determinant())) {
        continue;
      }
      best = {i, *covariance};
    }
  }
  add(anchor);
  return best;
}

template <class Pose>
void PlaceChain<Pose>::add(Key anchor) {
  places_.push_back(holds_(anchor) ? std::optional(anchor) : std::nullopt);
}

/// Of the places that the graph holds; else the last one.
template <class Pose>
std::size_t PlaceChain<Pose>::nearest(Key anchor) const {
  const auto at = pose(anchor).translation();
  std::size_t best = places_.size() - 1;
  double least = std::numeric_limits<double>::infinity();
  for (std::size_t i = 0; i < places_.size(); ++i) {
    const double distance = places_[i] ? (pose(*places_[i]).translation() - at).norm() : least;
    if (distance >= least) continue;
    least = distance;
    best = i;
  }
  return best;
}

/// Of where b is, seen from a; nothing where that is not known.
template <class Pose>
std::optional<typename Pose::Jacobian> PlaceChain<Pose>::covariance_between(Key a, Key b) const {
  Eigen::MatrixXd J(Pose::kDim, 2 * Pose::kDim);
  J << -pose(b).between(pose(a)).adjoint(), Pose::Jacobian::Identity();
  try {
    const typename Pose::Jacobian C = covariance_({a, b}, J);
    const bool is_known = C.diagonal().maxCoeff() < kLeastKnown * kLeastKnown;
    if (is_known && C.llt().info() == Eigen::Success) return 0.5 * (C + C.transpose());
  } catch (const SettingsError&) {  // a batch back-end, which solves at the end
  }
  return std::nullopt;
}

template class PlaceChain<SE2>;
template class PlaceChain<SE3>;

}  // namespace hybrid
