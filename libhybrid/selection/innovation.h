// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, the hybrid mapping authors
#pragma once

#include <Eigen/Core>
#include <vector>

#include "libhybrid/linear/path_inverse.h"
#include "libhybrid/linear/selected_inverse.h"
#include "libhybrid/solvers/problem.h"

namespace HYBRID_API hybrid {

/// A whitened residual b with Jacobian A at an estimate of covariance P.
struct Innovation {
  Eigen::VectorXd b;     ///< d entries
  Eigen::MatrixXd APAt;  ///< A P A', d x d
};

/// A measurement against all others: its innovation, whitened by its noise.
struct GivenOthers {
  Eigen::VectorXd b;
  Eigen::MatrixXd S;        ///< covariance of b
  double redundancy = 1.0;  ///< tr(S^-1) / d in [0, 1]: how far the others check it
};

/// The same from its residual at an estimate that it is part of or not. Of one that is part, with R
/// = I - A P A', the innovation is R^-1 b, of covariance R^-1.
GivenOthers given_others(const Innovation& innovation, bool is_part);

/// The innovation of a factor as if another one, which is part of the estimate, were not; `cross`
/// is A P B' of the two.
Innovation without(const Innovation& factor, const Innovation& part, const Eigen::MatrixXd& cross);

/// Covariances of relative measurements from the factorised system of a problem: columns of L^-1
/// along the paths of the elimination tree, kept by variable.
class InnovationPredictor {
 public:
  /// The problem must be linearised at `state`, assembled and factorised without damping, and
  /// outlive the predictor unchanged.
  InnovationPredictor(const Problem& problem, const Problem::State& state)
      : problem_(problem), state_(state), inverse_(problem.system().cholesky()) {}

  /// The whitened residual alone.
  Eigen::VectorXd residual(const ContinuousFactor& factor) const;
  Innovation predict(const ContinuousFactor& factor);
  /// The same for a factor that is part of the problem, from the selected inverse of the problem.
  Innovation predict_joined(const ContinuousFactor& factor, const SelectedInverse& inverse) const;
  /// A P B' for two factors.
  Eigen::MatrixXd cross(const ContinuousFactor& a, const ContinuousFactor& b);

 private:
  struct Linearized {
    Eigen::VectorXd b;
    Eigen::MatrixXd J;
    std::vector<int> blocks;
  };

  Linearized linearize(const ContinuousFactor& factor) const;
  Eigen::MatrixXd covariance(int a, int b);

  const Problem& problem_;
  const Problem::State& state_;
  PathInverse inverse_;
};

}  // namespace hybrid
