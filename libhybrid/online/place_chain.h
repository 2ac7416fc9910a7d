// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, the hybrid mapping authors

#pragma once

#include <cstddef>
#include <functional>
#include <optional>
#include <vector>

#include "libhybrid/core/values.h"
#include "libhybrid/online/known_places.h"

namespace HYBRID_API hybrid {

/// Tells of the places of a graph, one after the other, beside which of those before each is known
/// best: the one before it, or the nearest one. So a tree keeps of the joint density of all places
/// what neighbours have in common (Chow and Liu, 1968), in memory that grows with their number.
template <class Pose>
class PlaceChain {
 public:
  using Holds = std::function<bool(Key)>;
  /// Covariance of J x, with x the tangents of some variables stacked; throws SettingsError where
  /// it is not to be had.
  using Covariance =
      std::function<Eigen::MatrixXd(const std::vector<Key>& keys, const Eigen::MatrixXd& J)>;

  /// `values` has all variables that the graph holds.
  PlaceChain(const Values& values, Holds holds, Covariance covariance)
      : values_(values), holds_(std::move(holds)), covariance_(std::move(covariance)) {}

  /// The next place, which counts even where the graph does not hold it.
  void add(Key anchor);
  /// The same, and its parent.
  std::optional<PlaceParent<Pose>> next(Key anchor);

 private:
  Pose pose(Key key) const { return values_.at<Pose>(key); }
  std::size_t nearest(Key anchor) const;
  std::optional<typename Pose::Jacobian> covariance_between(Key a, Key b) const;

  const Values& values_;
  Holds holds_;
  Covariance covariance_;
  std::vector<std::optional<Key>> places_;  // nothing where the graph does not hold it
};

extern template class PlaceChain<SE2>;
extern template class PlaceChain<SE3>;

}  // namespace hybrid
