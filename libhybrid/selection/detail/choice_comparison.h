// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, the hybrid mapping authors
#pragma once

#include <vector>

#include "libhybrid/smoother/incremental.h"

namespace hybrid {

/// The costs of joint values of open choices (odometry steps with several hypotheses), given
/// closures that span them. The choices alone connect the pieces of trajectory between them, so
/// each piece is marginalised to the poses of choices and closures, in the frame of one of them
/// (RelativePoses), with the covariance of the map. The remaining graph is small, and is solved for
/// each joint value, since drift over hundreds of steps is too large for one linearisation.
class ChoiceComparison {
 public:
  /// `smoother` holds the poses and the choices, but not the closures, which are between poses.
  /// `choices` are in the order of their poses.
  ChoiceComparison(const IncrementalSmoother& smoother, const std::vector<HybridFactorPtr>& choices,
                   const std::vector<ContinuousFactorPtr>& closures);

  /// -log of the likelihood at its peak, up to a constant: values[i] is that of choice i.
  double cost(const std::vector<int>& values) const;

 private:
  std::vector<HybridFactorPtr> choices_;
  Values poses_;  // of choices and closures
  HybridGraph graph_;
};

}  // namespace hybrid
