// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, the hybrid mapping authors
#include "libhybrid/association/gate.h"

#include <Eigen/Cholesky>
#include <cmath>

#include "libhybrid/core/infinity.h"

namespace hybrid {

GaussianScore gaussian_score(const Eigen::VectorXd& residual, const Eigen::MatrixXd& covariance) {
  const Eigen::LLT<Eigen::MatrixXd> llt(covariance);
  if (llt.info() != Eigen::Success) return {kInfinity, kInfinity};
  const Eigen::VectorXd whitened = llt.matrixL().solve(residual);
  GaussianScore score;
  score.chi_square = whitened.squaredNorm();
  score.cost =
      0.5 * score.chi_square + 0.5 * static_cast<double>(residual.size()) * std::log(2 * M_PI);
  for (Eigen::Index i = 0; i < residual.size(); ++i) {
    score.cost += std::log(llt.matrixLLT()(i, i));
  }
  return score;
}

}  // namespace hybrid
