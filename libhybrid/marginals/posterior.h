// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, the hybrid mapping authors
#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <functional>
#include <unordered_map>
#include <vector>

#include "libhybrid/discrete/junction_forest.h"
#include "libhybrid/hybrid/graph.h"

namespace HYBRID_API hybrid {

/// How far enumeration goes, and how well sampling estimates.
struct PosteriorOptions {
  /// Up to so many joint values of the variables that choose components are enumerated, and the
  /// continuous variables optimised again for each; more are sampled, with all factors linearised
  /// at the estimate.
  std::size_t max_assignments = 64;
  /// Marginals of larger components: so many variables are sampled together, in the order given,
  /// and the middle half of them reported.
  int window = 16;
  double standard_error = 0.01;  ///< of sampled probabilities, where `max_sweeps` suffice
  int max_sweeps = 2000;
  std::uint64_t seed = 1;
  TableLimits limits;
};

/// What is known of one discrete variable.
struct DiscreteProbabilities {
  std::vector<double> p;
  std::vector<double> standard_error;  ///< of each, by sampling; empty where enumerated
};

/// The posterior of some discrete variables, the continuous ones integrated out.
struct AssignmentPosterior {
  /// Of every variable asked for, unless it is in `undetermined`.
  std::unordered_map<Key, DiscreteProbabilities> variables;
  /// Probabilities of the joint values of the variables asked for, row-major in their order; empty
  /// where sampled, or where one of them chooses no component.
  std::vector<double> joint;
  bool exact = true;  ///< false where sampled
  /// Discrete variables of which some value with a finite cost leaves continuous variables
  /// undetermined: their posterior is no number.
  std::vector<Key> undetermined;
  std::vector<Key> under_constrained;  ///< some of those continuous variables

  const DiscreteProbabilities& at(Key key) const;
};

/// The joint covariance of some continuous variables at the estimate, in their order: from a batch
/// factorisation, or from the Bayes tree. Empty where the factors do not determine all of them.
using JointCovariance = std::function<Eigen::MatrixXd(const std::vector<Key>&)>;

/// p(D | Z) of some discrete variables, given the values that an estimate has for all others that
/// choose components: every joint value counts with its Laplace evidence (see log_evidence), its
/// continuous variables optimised again. Beyond the variables that their components touch, the
/// graph counts as the Gaussian that it is at the estimate, which is exact where it is linear.
/// Variables that only weigh factors (classes) are summed out exactly. Where p(D | C, Z) of
/// eq. 11a is wanted, see discrete_marginals.
///
/// `covariance` is that of the estimate, which minimises L for its assignment. Throws Error for a
/// variable in no factor, and over the limits of tables.
AssignmentPosterior posterior(const HybridGraph& graph, const Estimate& estimate,
                              const std::vector<Key>& keys, const JointCovariance& covariance,
                              const PosteriorOptions& options = {});

/// The same from a batch factorisation of its own, where one is needed.
AssignmentPosterior posterior(const HybridGraph& graph, const Estimate& estimate,
                              const std::vector<Key>& keys, const PosteriorOptions& options = {});

/// p(d | Z) of each of some discrete variables: posterior() of their components of the discrete
/// graph, one after the other. Of a component with too many joint values, windows along the order
/// of `keys` are sampled, given the estimate's values outside. Without a covariance (null),
/// variables that choose components are undetermined.
AssignmentPosterior posterior_marginals(const HybridGraph& graph, const Estimate& estimate,
                                        const std::vector<Key>& keys,
                                        const JointCovariance& covariance,
                                        const PosteriorOptions& options = {});
AssignmentPosterior posterior_marginals(const HybridGraph& graph, const Estimate& estimate,
                                        const std::vector<Key>& keys,
                                        const PosteriorOptions& options = {});

}  // namespace hybrid
