// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, the hybrid mapping authors
#pragma once

#include <Eigen/Core>
#include <optional>
#include <vector>

#include "libhybrid/marginals/detail/site.h"

namespace hybrid {

/// Evidence of exchanging factors of a graph, all linearised at one estimate.
///
/// The factors of a site measure few directions of its variables: r = r_i + S_i u with u = B x for
/// factor i. With the present factors a, the directions u of all sites have a joint Gaussian of
/// mean zero and covariance G. If factors b replace them, the log evidence changes by
///   -log det(I + G M) / 2 + q' (I + G M)^-1 G q / 2,  beside the costs at the estimate, with
///   M = S_b'S_b - S_a'S_a  and  q = S_b'r_b - S_a'r_a,
/// over the exchanged sites alone. G is not inverted, so that a direction which only the present
/// factor determines does no harm.
class Exchange {
 public:
  Exchange(const JointGaussian& gaussian, const std::vector<Site>& sites);

  /// Change of the log evidence, without that of the costs at the estimate, when chosen[k] is the
  /// index of the factor at site k. Empty if these factors leave variables undetermined.
  std::optional<double> log_change(const std::vector<int>& chosen) const;

 private:
  struct Difference {  // between a factor and the present one, over the directions of their site
    Eigen::MatrixXd M;
    Eigen::VectorXd q;
  };
  struct Directions {
    int begin = 0;  // first row in G
    int size = 0;
    std::vector<Difference> factors;
    int present = 0;
  };

  std::vector<Directions> sites_;
  Eigen::MatrixXd G_;
};

}  // namespace hybrid
