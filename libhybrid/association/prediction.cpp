// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, the hybrid mapping authors
#include "libhybrid/association/prediction.h"

#include "libhybrid/geometry/so2.h"

namespace hybrid {

Eigen::VectorXd PredictedSightings::innovation(const Eigen::VectorXd& z, int j) const {
  Eigen::VectorXd out = z - mean.col(j);
  for (int k = 1; k < dim; ++k) out[k] = wrap_angle(out[k]);
  return out;
}

GaussianScore PredictedSightings::score(const MeasuredPoint& measured, int j) const {
  return gaussian_score(innovation(measured.z, j),
                        covariance.block(dim * j, dim * j, dim, dim) + measured.covariance);
}

GaussianScore PredictedSightings::score(const std::vector<MeasuredPoint>& measured,
                                        const Matching& matching) const {
  std::vector<int> rows;
  for (std::size_t i = 0; i < measured.size(); ++i) {
    if (matching.column[i] >= 0) rows.push_back(static_cast<int>(i));
  }
  const int n = static_cast<int>(rows.size());
  Eigen::VectorXd residual(dim * n);
  Eigen::MatrixXd S(dim * n, dim * n);
  for (int a = 0; a < n; ++a) {
    const int ja = matching.column[rows[a]];
    residual.segment(dim * a, dim) = innovation(measured[rows[a]].z, ja);
    for (int b = 0; b < n; ++b) {
      const int jb = matching.column[rows[b]];
      S.block(dim * a, dim * b, dim, dim) = covariance.block(dim * ja, dim * jb, dim, dim);
    }
    S.block(dim * a, dim * a, dim, dim) += measured[rows[a]].covariance;
  }
  return gaussian_score(residual, S);
}

}  // namespace hybrid
