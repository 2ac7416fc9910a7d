// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, the hybrid mapping authors
#pragma once

#include <vector>

#include "libhybrid/selection/closure_selection.h"
#include "libhybrid/smoother/incremental.h"

namespace hybrid {

/// Compares the joint values of open choices (odometry steps with several hypotheses), given
/// closures that span them. The choices alone connect the pieces of trajectory between them, so
/// each piece is marginalised to the poses of choices and closures, in the frame of one of them
/// (RelativePoses), with the covariance of the map. The remaining graph is small, and is solved for
/// each joint value, since drift over hundreds of steps is too large for one linearisation. Pose is
/// SE2 or SE3.
template <class Pose>
class ChoiceComparison {
 public:
  /// `smoother` holds the poses and the choices, but not the closures, which are between poses; it
  /// outlives the comparison. `choices` are in the order of their poses. Closures that may be false
  /// are selected for each joint value by select_closures, a false one being uniform over a map of
  /// that radius [m].
  ChoiceComparison(const IncrementalSmoother& smoother, const std::vector<HybridFactorPtr>& choices,
                   const std::vector<ContinuousFactorPtr>& true_closures,
                   const std::vector<ContinuousFactorPtr>& uncertain_closures,
                   const ClosureSelectionOptions& options, double radius);

  struct Fit {
    double cost = 0.0;      ///< half the weighted squared error
    double evidence = 0.0;  ///< log, the poses integrated out (E1), up to a constant
    std::vector<bool> in;   ///< closures that may be false and are taken for true
  };
  /// values[i] is that of choice i.
  Fit fit(const std::vector<int>& values) const;

 private:
  Values start(const std::vector<int>& values) const;

  std::vector<HybridFactorPtr> choices_;
  std::vector<ContinuousFactorPtr> fixed_, uncertain_;
  ClosureSelectionOptions options_;
  double radius_;
  Values poses_;  // of choices and closures
};

}  // namespace hybrid
