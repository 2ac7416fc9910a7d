// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, the hybrid mapping authors

#include "libhybrid/factors/motion_covariance.h"

#include <Eigen/LU>

namespace hybrid {

Eigen::MatrixXd covariance_after_motion(const ContinuousFactor& motion, const Values& newest,
                                        const Values& values, const CovarianceOf& covariance_of,
                                        std::vector<Key> keys, const Eigen::MatrixXd& J) {
  std::vector<const double*> x;
  for (const Key key : motion.keys()) {
    x.push_back(newest.contains(key) ? newest.data(key) : values.data(key));
  }
  const int rows = motion.rows();
  Eigen::VectorXd r(rows);
  Eigen::MatrixXd linear(rows, motion.cols());
  motion.linearize(x.data(), r.data(), linear.data());
  const Eigen::MatrixXd noise = linear.rightCols(rows).inverse();
  const Eigen::MatrixXd by_noise = J.leftCols(rows) * noise;
  const Eigen::MatrixXd own = by_noise * by_noise.transpose();
  const Eigen::Index known = J.cols() - rows;
  if (motion.keys().size() == 1) {
    return keys.empty() ? own : own + covariance_of(keys, J.rightCols(known));
  }
  keys.insert(keys.begin(), motion.keys().front());
  Eigen::MatrixXd by_graph(J.rows(), rows + known);
  by_graph << -by_noise * linear.leftCols(rows), J.rightCols(known);
  return own + covariance_of(keys, by_graph);
}

Eigen::MatrixXd covariance_after_motion(const ContinuousFactor& motion, const Values& newest,
                                        const Values& values, const CovarianceOf& covariance_of,
                                        const std::vector<Key>& keys) {
  int dims = motion.rows();
  for (const Key key : keys) dims += values.type(key).dim;
  return covariance_after_motion(motion, newest, values, covariance_of, keys,
                                 Eigen::MatrixXd::Identity(dims, dims));
}

}  // namespace hybrid
