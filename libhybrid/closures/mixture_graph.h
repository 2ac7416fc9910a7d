// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, the hybrid mapping authors
#pragma once

#include <functional>
#include <optional>
#include <vector>

#include "libhybrid/closures/problem.h"
#include "libhybrid/core/key_letters.h"
#include "libhybrid/core/option.h"
#include "libhybrid/hybrid/graph.h"
#include "libhybrid/pose_graph/pose_graph.h"

namespace HYBRID_API hybrid {

/// The model of inliers and outliers (eq. 17). All that take it throw SettingsError, which names
/// the option, unless the variance is from 1 to 1e12, weights are positive and finite, and the null
/// hypothesis is finite.
struct MixtureOptions {
  double outlier_variance = 1e7;
  bool flat = false;  ///< outliers have no gradient, however large their residuals
  std::optional<double> null_hypothesis;
  double inlier_weight = 0.5;
  double outlier_weight = 0.5;

  template <class Table>
  static void describe(Table& table) {
    using O = MixtureOptions;
    table.option("outlier_variance", &O::outlier_variance, {1, 1e12},
                 "variance of a false closure in those of a true one");
    table.option("inlier_weight", &O::inlier_weight, {0.0, 1.0, true},
                 "prior probability of a true closure");
    table.field("outlier_weight", &O::outlier_weight, "that of a false one");
    table.option("flat", &O::flat,
                 "false closures have a constant density, that of the peak of this Gaussian");
    table.field("null_hypothesis", &O::null_hypothesis,
                "instead of all that: constant -log density of a false closure");
  }
};

/// The switch of a closure: value 0 is inlier, 1 outlier.
inline DiscreteKey closure_switch(std::size_t closure) {
  return {Key(key_letter::kClosureSwitch, closure), 2};
}

/// The mixture of eq. 17 for one closure. Its outlier component is weak (see Component::weak) if it
/// is constant, or as wide as make_outlier_mixture requires.
HybridFactorPtr closure_mixture(std::size_t closure, const ContinuousFactorPtr& factor,
                                const MixtureOptions& options = {});

/// The outlier component of a closure as a line over its squared whitened norm s: relative to the
/// inlier, which costs s / 2, the outlier costs (s / variance + offset) / 2.
struct OutlierLine {
  double variance = 1.0;  ///< infinite if the outlier model is constant
  double offset = 0.0;
};
OutlierLine outlier_line(const ContinuousFactor& closure, const MixtureOptions& options);

/// The graph of eq. 16: trusted factors as they are, every closure a mixture.
HybridGraph mixture_graph(const RobustProblem& problem, const MixtureOptions& options = {});

/// Trusted factors and accepted closures. Throws Error where there is not a decision on each.
std::vector<ContinuousFactorPtr> factors_in_force(const RobustProblem& problem,
                                                  const std::vector<bool>& accepted);

/// The assignment of the switches, by closure.
Assignment to_assignment(const std::vector<bool>& accepted);

/// Objective and cost of values and decisions. This and the next throw Error where there is not a
/// decision on each closure.
struct JointObjective {
  double objective = 0.0;  ///< of eq. 6, see RobustResult
  double cost = 0.0;       ///< half the weighted squared error of trusted and accepted factors
};
JointObjective joint_objective(const RobustProblem& problem, const Values& values,
                               const std::vector<bool>& accepted,
                               const MixtureOptions& options = {});

/// The decisions on closures that are accepted or not, at these values (eq. 14), with redundancies
/// of one.
std::vector<ClosureDecision> make_decisions(const RobustProblem& problem, const Values& values,
                                            const std::vector<bool>& accepted,
                                            const MixtureOptions& options = {});

/// Whether a relative pose is trusted; all others are candidate closures.
using Trust = std::function<bool(Key from, Key to)>;

/// A pose graph as a robust problem: relative poses that are not trusted are the closures, in the
/// order of the graph; sightings of landmarks and priors are trusted, and odometry if `trusted` is
/// empty. `initial` holds all variables.
RobustProblem to_robust_problem(const PoseGraph& graph, const Values& initial,
                                const Trust& trusted = {}, const GraphFactorOptions& options = {});

}  // namespace hybrid
