// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, the hybrid mapping authors

#pragma once

#include <vector>

#include "libhybrid/geometry/eigen.h"
#include "libhybrid/hybrid/graph.h"

namespace HYBRID_API hybrid {

/// One landmark given some of those before it: R [x_i - m_i; x_given - m_given] is N(0, I).
struct SparseRow {
  std::vector<int> variables;  ///< the landmark itself, then those that it is given
  Eigen::MatrixXd R;           ///< dim rows, dim columns for each variable
};

/// The joint density of landmarks as a product of conditional ones, each given a few landmarks
/// before it: the Cholesky factor of the information that loses least, in Kullback-Leibler
/// divergence, among those with these few entries (Schaefer, Katzfuss, Owhadi 2021).
struct SparseGaussian {
  int dim = 2;                  ///< of a landmark
  std::vector<SparseRow> rows;  ///< one per landmark, in their order
  double loss = 0;              ///< divergence of this from the joint density [nat]

  /// The joint covariance that the rows stand for.
  Eigen::MatrixXd covariance() const;
  /// The covariance of each landmark alone, by what the rows couple: time and memory are those of a
  /// sparse factorisation.
  std::vector<Eigen::MatrixXd> covariances() const;
};

/// Splits a joint covariance, dim rows for each landmark, so that no more than `most_loss` [nat]
/// is lost; a landmark is given those before it that are known best relative to it, four, eight
/// and so on until that holds, or all. Throws Error where the covariance is not positive definite.
SparseGaussian sparsify(const Eigen::MatrixXd& covariance, int dim, double most_loss = 0.1);

/// The joint density of some points of a graph, all other variables integrated out, as sparsify()
/// splits a joint covariance. Of more than a thousand points each is given at most 32, of the 64
/// before it that are nearest: time and memory are then those of a sparse factorisation. Throws
/// Error where the graph does not determine its variables.
SparseGaussian sparsify(const HybridGraph& graph, const Values& values,
                        const std::vector<Key>& points, int dim, double most_loss = 0.1);

}  // namespace hybrid
