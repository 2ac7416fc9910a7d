// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, the hybrid mapping authors
#pragma once

#include <Eigen/Core>
#include <string>
#include <vector>

#include "libhybrid/hybrid/graph.h"
#include "libhybrid/solvers/problem.h"

namespace hybrid {

/// Covariance blocks of many variables, by key.
class Covariances {
 public:
  bool contains(Key key) const { return places_.count(key) != 0; }
  std::size_t size() const { return places_.size(); }
  /// Square, over the tangent of the variable; throws Error for a key that is not there.
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
  int threads = 0;
  /// Weak components belong to the Hessian of eq. 13; left uncoupled they cost no fill-in, and
  /// count as if they measured each of their variables alone.
  WeakComponents weak = WeakComponents::kCoupled;
};

/// Laplace approximation of the continuous marginals given the assignment (eq. 11b to 14), over the
/// tangent spaces at the estimate, from the Cholesky factor of J'J. Factorised once.
class ContinuousMarginals {
 public:
  /// Throws Error for missing values. The graph may go afterwards.
  ContinuousMarginals(const HybridGraph& graph, const Estimate& estimate,
                      const MarginalOptions& options = {});

  /// False where the information matrix is singular: then `under_constrained` names variables, and
  /// asking for a covariance throws Error.
  bool valid() const { return under_constrained_.empty(); }
  const std::vector<Key>& under_constrained() const { return under_constrained_; }

  /// Covariance of one variable. Throws Error for a variable in no factor.
  Eigen::MatrixXd covariance(Key key) const { return joint_covariance({key}); }
  /// Joint covariance of some variables, in the order given; costs their paths to the root of the
  /// elimination tree.
  Eigen::MatrixXd joint_covariance(const std::vector<Key>& keys) const;
  /// Covariances of all variables, by selected inversion.
  Covariances all() const;

 private:
  void check_valid() const;

  Problem problem_;
  mutable WorkerPool pool_;
  std::vector<Key> under_constrained_;
};

}  // namespace hybrid
