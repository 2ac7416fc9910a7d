// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, the hybrid mapping authors
#pragma once

#include <algorithm>
#include <deque>

#include "libhybrid/selection/prediction.h"

namespace HYBRID_API hybrid {

/// Estimate of the ratio of real to stated variances, at most 1: the lower quartile of the squared
/// innovations of accepted closures, over that of the chi-square distribution. Overstated
/// covariances, as in many published graphs, would let false closures through any gate. The
/// quartile is over innovations of about the same predicted size, since the drift over a long path
/// and the noise of neighbouring measurements may be overstated differently.
class VarianceFactor {
 public:
  /// An accepted closure, with the innovation that it had before.
  void add(const Prediction& innovation, int rows);

  /// Bounds the factor by that of an evaluation of all closures.
  void limit(double factor) { limit_ = std::min(1.0, factor); }

  /// The factor for an innovation; 1 while nothing is known. Never above 1.
  double at(const Prediction& innovation, int rows) const;

  /// Whether an innovation is inside its gate. Up to a redundancy of one half, the gate is a
  /// quantile of its distribution, scaled by the factor; from there to a redundancy of one it
  /// approaches `checked`, the gate of measurements that can do no harm. 0: the gate does not
  /// depend on the redundancy.
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
