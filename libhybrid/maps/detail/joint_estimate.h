// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, the hybrid mapping authors

#pragma once

#include <memory>
#include <utility>
#include <vector>

#include "libhybrid/hybrid/graph.h"
#include "libhybrid/maps/map_record.h"
#include "libhybrid/marginals/continuous.h"

namespace hybrid {

/// Landmarks of two maps that are one, by their places in these.
using LandmarkPairs = std::vector<std::pair<int, int>>;

/// All landmarks of two maps in the frame of the first, and the motion between the maps, given
/// which landmarks are one. Of the motion nothing is known but what these say: its prior is flat.
template <class Pose>
class JointEstimate {
 public:
  using Point = typename Pose::Point;
  static constexpr int kDim = Point::RowsAtCompileTime;

  /// The maps must outlive this.
  JointEstimate(const MapRecord& first, const MapRecord& second) : a_(first), b_(second) {}

  /// What else is known of the motion: it is this, with a covariance in its tangent.
  void know(const Pose& T_first_second, const typename Pose::Jacobian& covariance);

  /// Estimates all, from a guess of the motion. The pairs must determine it, where nothing else is
  /// known of it.
  void estimate(const LandmarkPairs& pairs, const Pose& T_first_second);

  const Pose& T_first_second() const { return T_; }
  /// Of that, in the tangent of a right perturbation.
  typename Pose::Jacobian covariance() const;
  /// The variable of a landmark of the first or second map; pairs have one.
  Key first(int i) const { return Key('a', static_cast<std::uint64_t>(i)); }
  Key second(int j) const { return keys_of_b_[static_cast<std::size_t>(j)]; }
  Point at(Key landmark) const { return values_.at<Point>(landmark); }
  const HybridGraph& graph() const { return graph_; }
  const Values& values() const { return values_; }
  const ContinuousMarginals& marginals() const { return *marginals_; }

  /// Of the pairs, with 2 or 3 for each degrees of freedom less those of the motion.
  double chi_square() const { return chi_square_; }
  /// The log of the density of the pairs being one each, per m^2 or m^3 for each, with the motion
  /// integrated out, per the unit of its tangent.
  double log_density() const { return log_density_; }

 private:
  void add_priors();

  const MapRecord &a_, &b_;
  std::vector<Key> keys_of_b_;
  HybridGraph graph_;
  Values values_;
  std::unique_ptr<ContinuousMarginals> marginals_;
  Pose T_;
  ContinuousFactorPtr known_;  // of the motion, or null
  double chi_square_ = 0, log_density_ = 0;
};

}  // namespace hybrid
