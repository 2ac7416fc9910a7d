// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, the hybrid mapping authors

#include "libhybrid/factors/motion_covariance.h"

#include <Eigen/LU>

namespace hybrid {

Eigen::MatrixXd covariance_after_motion(
    const ContinuousFactor& motion, const Values& newest, const Values& values,
    const std::function<Eigen::MatrixXd(const std::vector<Key>&)>& joint_covariance,
    std::vector<Key> keys) {
  const bool first = motion.keys().size() == 1;
  std::vector<const double*> x;
  for (const Key key : motion.keys()) {
    x.push_back(newest.contains(key) ? newest.data(key) : values.data(key));
  }
  const int rows = motion.rows();
  Eigen::VectorXd r(rows);
  Eigen::MatrixXd J(rows, motion.cols());
  motion.linearize(x.data(), r.data(), J.data());
  const Eigen::MatrixXd noise = J.rightCols(rows).inverse();
  if (first) {  // independent of all that is in the graph
    const Eigen::MatrixXd known = keys.empty() ? Eigen::MatrixXd(0, 0) : joint_covariance(keys);
    Eigen::MatrixXd all = Eigen::MatrixXd::Zero(rows + known.rows(), rows + known.rows());
    all.topLeftCorner(rows, rows) = noise * noise.transpose();
    all.bottomRightCorner(known.rows(), known.rows()) = known;
    return all;
  }
  keys.insert(keys.begin(), motion.keys().front());
  Eigen::MatrixXd joint = joint_covariance(keys);
  const Eigen::MatrixXd F = -noise * J.leftCols(rows);
  joint.topRows(rows) = (F * joint.topRows(rows)).eval();
  joint.leftCols(rows) = (joint.leftCols(rows) * F.transpose()).eval();
  joint.topLeftCorner(rows, rows) += noise * noise.transpose();
  return joint;
}

}  // namespace hybrid
