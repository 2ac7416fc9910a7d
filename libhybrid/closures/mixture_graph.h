// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, the hybrid mapping authors
#pragma once

#include <functional>
#include <optional>
#include <vector>

#include "libhybrid/closures/problem.h"
#include "libhybrid/core/key_letters.h"
#include "libhybrid/hybrid/graph.h"
#include "libhybrid/pose_graph/pose_graph.h"

namespace HYBRID_API hybrid {

/// What a false closure looks like (eq. 17).
struct MixtureOptions {
  /// The outlier model is the inlier's with its covariance multiplied by this.
  double outlier_variance = 1e7;
  /// Whether the outlier model is constant, at the peak of that Gaussian: the same switch, and
  /// false closures, however absurd, do not pull at the map.
  bool flat = false;
  /// Instead of both: -log density of a false closure, the same wherever the poses are.
  std::optional<double> null_hypothesis;
  /// Prior weights of the two, positive.
  double inlier_weight = 0.5;
  double outlier_weight = 0.5;
};

/// The switch of a closure: value 0 is inlier, 1 outlier.
inline DiscreteKey closure_switch(std::size_t closure) {
  return {Key(key_letter::kClosureSwitch, closure), 2};
}

/// The mixture of eq. 17 for one closure, whose outlier component is weak (see Component::weak).
/// Throws Error for weights that are not positive.
HybridFactorPtr closure_mixture(std::size_t closure, const ContinuousFactorPtr& factor,
                                const MixtureOptions& options = {});

/// The two components of a closure as lines over its squared whitened norm s: where the inlier
/// costs s / 2, the outlier costs half of s / variance + offset. Throws Error for weights that are
/// not positive.
struct OutlierLine {
  double variance = 1.0;  ///< infinite where the outlier model is constant
  double offset = 0.0;
};
OutlierLine outlier_line(const ContinuousFactor& closure, const MixtureOptions& options);

/// The graph of eq. 16: trusted factors as they are, every closure a mixture. Throws
/// Error for weights that are not positive.
HybridGraph mixture_graph(const RobustProblem& problem, const MixtureOptions& options = {});

/// The assignment of the switches, by closure.
Assignment to_assignment(const std::vector<bool>& accepted);

/// Objective and cost of an answer.
struct JointObjective {
  double objective = 0.0;  ///< of eq. 6, see RobustResult
  double cost = 0.0;       ///< half the weighted squared error of trusted and accepted factors
};
JointObjective joint_objective(const RobustProblem& problem, const Values& values,
                               const std::vector<bool>& accepted,
                               const MixtureOptions& options = {});

/// The verdicts that `accepted` and `values` amount to (eq. 14): redundancies are left at one.
std::vector<Verdict> make_verdicts(const RobustProblem& problem, const Values& values,
                                   const std::vector<bool>& accepted,
                                   const MixtureOptions& options = {});

/// Whether a relative pose is trusted as it is.
using Trust = std::function<bool(Key from, Key to)>;

/// A pose graph as a robust problem: relative poses that are not trusted are the closures, in the
/// order of the graph; sightings of landmarks and priors are trusted. `initial` holds all
/// variables.
RobustProblem to_robust_problem(const PoseGraph& graph, const Values& initial,
                                const Trust& trusted = is_odometry,
                                const GraphFactorOptions& options = {});

}  // namespace hybrid
