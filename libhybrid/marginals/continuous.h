// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, the hybrid mapping authors
#pragma once

#include <Eigen/Core>
#include <functional>
#include <optional>
#include <string>
#include <unordered_map>
#include <vector>

#include "libhybrid/hybrid/graph.h"
#include "libhybrid/solvers/problem.h"

namespace HYBRID_API hybrid {

/// The joint covariance of some continuous variables at the estimate, in their order: from a batch
/// factorisation, or from the Bayes tree. Empty if the factors do not determine all of them.
using JointCovariance = std::function<Eigen::MatrixXd(const std::vector<Key>&)>;

/// Covariance blocks of many variables, by key.
class Covariances {
 public:
  bool contains(Key key) const { return places_.count(key) != 0; }
  std::size_t size() const { return places_.size(); }
  std::vector<Key> keys() const;  ///< sorted
  /// Square, over the tangent of the variable; throws Error for a variable without covariance.
  Eigen::Map<const Eigen::MatrixXd> at(Key key) const;
  void insert(Key key, const Eigen::MatrixXd& covariance);

 private:
  struct Place {
    std::size_t begin = 0;
    int dim = 0;
  };
  std::unordered_map<Key, Place> places_;
  std::vector<double> entries_;
};

struct MarginalOptions {
  int threads = 0;  ///< 0: one per core, at most 4; the result is the same for any number
};

/// Laplace approximation of the continuous marginals given the assignment (eq. 11b to 14), over the
/// tangent spaces at the estimate: the inverse of J'J of all chosen components (eq. 13), weak ones
/// included, from its Cholesky factor. Factorised once; in extended precision if it is singular, or
/// so nearly that rounding would matter.
class ContinuousMarginals {
 public:
  /// Throws Error for missing values. The graph is not needed afterwards.
  ContinuousMarginals(const HybridGraph& graph, const Estimate& estimate,
                      const MarginalOptions& options = {});

  /// Whether the factors determine all variables. If not, `under_constrained` names the
  /// undetermined ones: asking for the covariance of one throws Error, and the covariances of the
  /// others do not depend on their values.
  bool valid() const { return under_constrained_.empty(); }
  const std::vector<Key>& under_constrained() const { return under_constrained_; }

  /// Covariance of one variable. Throws Error for a variable in no factor.
  Eigen::MatrixXd covariance(Key key) const { return joint_covariance({key}); }
  /// Joint covariance of some variables, in the order given; costs their paths to the root of the
  /// elimination tree.
  Eigen::MatrixXd joint_covariance(const std::vector<Key>& keys) const;
  /// Covariances of all variables that the factors determine, by selected inversion.
  Covariances all() const;

 private:
  std::vector<int> determined_blocks(const std::vector<Key>& keys) const;

  Problem problem_;
  mutable WorkerPool pool_;
  std::optional<ExtendedCholesky> extended_;  // replaces the factor of a singular problem
  std::vector<Key> under_constrained_;
};

}  // namespace hybrid
