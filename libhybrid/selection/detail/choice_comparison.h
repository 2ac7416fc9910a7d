// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, the hybrid mapping authors
#pragma once

#include <vector>

#include "libhybrid/smoother/incremental.h"

namespace hybrid {

/// What joint values of open choices (odometry steps with several hypotheses) cost, given closures
/// that span them. Nothing but the choices themselves connects the pieces of trajectory between
/// them, so each piece is marginalised to the poses that matter, as seen from one of them
/// (RelativePoses), with the covariance of the map. The graph that remains is small, and is solved
/// for each joint value: drift over hundreds of steps bends it by more than a linearisation bears.
class ChoiceComparison {
 public:
  /// `smoother` holds the poses, the choices (in the order of their poses) and not the closures,
  /// which are between poses.
  ChoiceComparison(const IncrementalSmoother& smoother, const std::vector<HybridFactorPtr>& choices,
                   const std::vector<ContinuousFactorPtr>& closures);

  /// -log of the likelihood at its peak, up to a constant: values[i] is that of choice i.
  double cost(const std::vector<int>& values) const;

 private:
  std::vector<HybridFactorPtr> choices_;
  Values poses_;  // that matter
  HybridGraph graph_;
};

}  // namespace hybrid
