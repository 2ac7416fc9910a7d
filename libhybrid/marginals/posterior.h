// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, the hybrid mapping authors
#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <unordered_map>
#include <vector>

#include "libhybrid/discrete/junction_forest.h"
#include "libhybrid/hybrid/graph.h"
#include "libhybrid/marginals/continuous.h"

namespace HYBRID_API hybrid {

/// Limits of enumeration, and the accuracy of sampling.
struct PosteriorOptions {
  /// Up to this many joint values of the variables that choose components are enumerated, and the
  /// continuous variables are optimised again for each; more are sampled, with all factors
  /// linearised at the estimate.
  std::size_t max_assignments = 64;
  /// Marginals of larger components: this many variables are sampled together, in the order given,
  /// and the middle half of them are reported.
  int window = 16;
  double standard_error = 0.01;  ///< of sampled probabilities, if `max_sweeps` suffice
  int max_sweeps = 2000;
  std::uint64_t seed = 1;
  TableLimits limits;
};

/// The probabilities of the values of one discrete variable.
struct DiscreteProbabilities {
  std::vector<double> p;
  std::vector<double> standard_error;  ///< of each probability if sampled; empty if enumerated
};

/// The posterior of some discrete variables, the continuous ones integrated out.
struct AssignmentPosterior {
  /// The probabilities of every variable asked for, unless it is in `undetermined`.
  std::unordered_map<Key, DiscreteProbabilities> variables;
  /// Probabilities of the joint values of the variables asked for, row-major in their order; empty
  /// if sampled, or if one of them chooses no component.
  std::vector<double> joint;
  bool exact = true;  ///< false if sampled
  /// Discrete variables without a posterior: some value with a finite cost leaves continuous
  /// variables undetermined.
  std::vector<Key> undetermined;
  std::vector<Key> under_constrained;  ///< some of those continuous variables

  const DiscreteProbabilities& at(Key key) const;
};

/// p(D | Z) of some discrete variables, given the values that an estimate has for all others that
/// choose components: every joint value is weighted by its Laplace evidence (see log_evidence),
/// with the continuous variables optimised again. In a large graph, the rest beyond the variables
/// of their components is replaced by its Gaussian at the estimate, which is exact if it is linear.
/// Variables that only weight factors (classes) are summed out exactly. For p(D | C, Z) of eq. 11a
/// see discrete_marginals.
///
/// `covariance` is that at the estimate, which minimises L for its assignment. Throws Error for a
/// variable in no factor, and over the limits of tables.
AssignmentPosterior posterior(const HybridGraph& graph, const Estimate& estimate,
                              const std::vector<Key>& keys, const JointCovariance& covariance,
                              const PosteriorOptions& options = {});

/// The same, with covariances from a batch factorisation if they are needed.
AssignmentPosterior posterior(const HybridGraph& graph, const Estimate& estimate,
                              const std::vector<Key>& keys, const PosteriorOptions& options = {});

/// Of each of some discrete variables, p(d | Z, others): posterior() of each connected component of
/// the discrete graph that holds some of them, given the values that the estimate has for all other
/// components. That is p(d | Z) unless components share continuous variables through which they
/// bear on each other; posterior() of several such together sums over all of them. In a component
/// with too many joint values, windows along the order of `keys` are sampled, given the values of
/// the estimate outside. If `covariance` returns an empty matrix, variables that choose components
/// are undetermined.
AssignmentPosterior posterior_marginals(const HybridGraph& graph, const Estimate& estimate,
                                        const std::vector<Key>& keys,
                                        const JointCovariance& covariance,
                                        const PosteriorOptions& options = {});
AssignmentPosterior posterior_marginals(const HybridGraph& graph, const Estimate& estimate,
                                        const std::vector<Key>& keys,
                                        const PosteriorOptions& options = {});

}  // namespace hybrid
