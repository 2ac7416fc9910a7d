// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, the hybrid mapping authors

#pragma once

#include <cmath>

#include "libhybrid/export.h"

namespace HYBRID_API hybrid {

/// How often looks detect a thing that they have in view. Each thing has a probability of its own,
/// which is known beforehand as well as ten looks tell it (a beta distribution): a thing that hides
/// from one look is likely to hide from the next.
class DetectionModel {
 public:
  /// Looks at one thing that what is known beforehand counts as much as.
  static constexpr double kPriorLooks = 10;

  /// `detected` is the mean of the probabilities of all things.
  explicit DetectionModel(double detected)
      : hits_(kPriorLooks * detected), misses_(kPriorLooks - hits_) {}

  /// log of the probability that certain `hits` of so many looks detect a thing, and that the
  /// others do not.
  double log_probability(int hits, int looks) const {
    return std::lgamma(hits_ + hits) - std::lgamma(hits_) + std::lgamma(misses_ + looks - hits) -
           std::lgamma(misses_) + std::lgamma(kPriorLooks) - std::lgamma(kPriorLooks + looks);
  }

  /// log of the density of a thing's probability p, up to a constant.
  double log_density(double p) const {
    return (hits_ - 1) * std::log(p) + (misses_ - 1) * std::log1p(-p);
  }

 private:
  double hits_, misses_;  // parameters of the beta distribution
};

}  // namespace hybrid
