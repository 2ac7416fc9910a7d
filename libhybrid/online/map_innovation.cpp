// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, the hybrid mapping authors
#include "libhybrid/online/detail/map_innovation.h"

#include <algorithm>
#include <map>
#include <vector>

#include "libhybrid/factors/linear_at.h"

namespace hybrid {

Innovation innovation_of(const ContinuousFactor& factor, const IncrementalSmoother& smoother) {
  const ResidualAndJacobian at = linear_at(factor, smoother.values());
  return {at.r, at.J * smoother.joint_covariance(factor.keys()) * at.J.transpose()};
}

Eigen::MatrixXd cross_covariance(const ContinuousFactor& a, const ContinuousFactor& b,
                                 const IncrementalSmoother& smoother) {
  std::vector<Key> keys = a.keys();
  for (Key key : b.keys()) {
    if (std::find(keys.begin(), keys.end(), key) == keys.end()) keys.push_back(key);
  }
  std::map<Key, int> column;
  int columns = 0;
  for (Key key : keys) {
    column[key] = columns;
    columns += smoother.values().type(key).dim;
  }
  const auto spread = [&](const ContinuousFactor& factor) {
    const Eigen::MatrixXd A = linear_at(factor, smoother.values()).J;
    Eigen::MatrixXd J = Eigen::MatrixXd::Zero(factor.rows(), columns);
    int at = 0;
    for (Key key : factor.keys()) {
      const int dim = smoother.values().type(key).dim;
      J.middleCols(column[key], dim) = A.middleCols(at, dim);
      at += dim;
    }
    return J;
  };
  return spread(a) * smoother.joint_covariance(keys) * spread(b).transpose();
}

}  // namespace hybrid
