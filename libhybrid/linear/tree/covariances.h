// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, the hybrid mapping authors
#pragma once

#include <Eigen/Core>
#include <functional>
#include <vector>

#include "libhybrid/geometry/eigen.h"
#include "libhybrid/linear/tree/pending_rows.h"

namespace HYBRID_API hybrid {

/// Covariances by the cliques of a Bayes tree, in tangents at the estimates if there are charts.
class TreeCovariances {
 public:
  TreeCovariances(const LinearSystem& system, const Cliques& cliques, const PendingRows& pending,
                  const Charts* charts)
      : system_(system), cliques_(cliques), pending_(pending), charts_(charts) {}

  /// Forward substitution, along the paths of some variables to the root alone, of rows J of these.
  PathRows substitute(const std::vector<int>& variables, const Eigen::MatrixXd& J) const;

  /// Joint covariance of some variables, in their order.
  Eigen::MatrixXd joint(const std::vector<int>& variables) const;
  /// Covariance J Sigma J' of J x, with x the variables stacked and Sigma their joint covariance,
  /// without computing Sigma: J x may be known to a millimetre where x itself is known to a
  /// kilometre, and Sigma is not precise enough to tell.
  Eigen::MatrixXd joint(const std::vector<int>& variables, const Eigen::MatrixXd& J) const;
  /// Covariances of all variables by one recursion from the roots (Takahashi), visited as
  /// visit(variable, dim x dim covariance).
  void visit(
      const std::function<void(int variable, const Eigen::MatrixXd& covariance)>& visit) const;

 private:
  const LinearSystem& system_;
  const Cliques& cliques_;
  const PendingRows& pending_;
  const Charts* charts_;
};

}  // namespace hybrid
