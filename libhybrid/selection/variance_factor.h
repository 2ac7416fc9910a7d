// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, the hybrid mapping authors
#pragma once

#include <algorithm>
#include <deque>

#include "libhybrid/selection/prediction.h"

namespace HYBRID_API hybrid {

/// How far real noise is below what measurements claim: the lower quartile of the squared
/// innovations of closures that were accepted, over that of the chi-square distribution.
/// Covariances that are overstated, as many published graphs have them, would let false closures
/// through any gate. The quartile is that of innovations of about the same predicted size, since
/// drift over a long path and noise of neighbouring measurements are stated by different people.
class VarianceFactor {
 public:
  /// An accepted closure, with the innovation that it had before.
  void add(const Prediction& innovation, int rows);

  /// Bounds the factor by what an evaluation of all closures found.
  void limit(double factor) { limit_ = std::min(1.0, factor); }

  /// The factor for an innovation; 1 while nothing is known. Never above 1.
  double at(const Prediction& innovation, int rows) const;

  /// Whether an innovation is inside its gate. That is a quantile of its distribution, the factor
  /// allowed for, where others check the measurement by half or less; above that it comes nearer
  /// to `checked`, the gate of measurements that can do no harm; 0 if that is the same.
  bool within(double quantile, const Prediction& innovation, int rows, double checked) const;

 private:
  struct Sample {
    double size;   // log |S| per row
    double ratio;  // of the squared innovation to the lower quartile of its distribution
  };
  std::deque<Sample> samples_;
  double limit_ = 1.0;
};

}  // namespace hybrid
