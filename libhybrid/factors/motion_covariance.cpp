// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, the hybrid mapping authors

#include "libhybrid/factors/motion_covariance.h"

#include <Eigen/LU>
#include <utility>

namespace hybrid {

MotionCovariance::MotionCovariance(const ContinuousFactor& motion, Key pose, const Values& newest,
                                   const Values& values, CovarianceOf covariance_of)
    : values_(&values), covariance_of_(std::move(covariance_of)) {
  std::vector<const double*> x;
  for (const Key key : motion.keys()) {
    x.push_back(newest.contains(key) ? newest.data(key) : values.data(key));
  }
  Eigen::VectorXd r(motion.rows());
  Eigen::MatrixXd linear(motion.rows(), motion.cols());
  motion.linearize(x.data(), r.data(), linear.data());
  by_from_.resize(motion.rows(), 0);
  Eigen::Index at = 0;
  for (const Key key : motion.keys()) {
    const bool known = values.contains(key);
    const Eigen::Index dim = (known ? values : newest).type(key).dim;
    const auto columns = linear.middleCols(at, dim);
    at += dim;
    if (key == pose) {
      noise_ = columns.inverse();
    } else if (known) {
      from_.push_back(key);
      by_from_.conservativeResize(Eigen::NoChange, by_from_.cols() + dim);
      by_from_.rightCols(dim) = columns;
    }
  }
}

Eigen::MatrixXd MotionCovariance::operator()(std::vector<Key> keys,
                                             const Eigen::MatrixXd& J) const {
  const Eigen::MatrixXd by_noise = J.leftCols(noise_.rows()) * noise_;
  const Eigen::MatrixXd own = by_noise * by_noise.transpose();
  keys.insert(keys.begin(), from_.begin(), from_.end());
  if (keys.empty()) return own;
  const Eigen::Index known = J.cols() - noise_.rows();
  Eigen::MatrixXd by_graph(J.rows(), by_from_.cols() + known);
  by_graph << -by_noise * by_from_, J.rightCols(known);
  return own + covariance_of_(keys, by_graph);
}

Eigen::MatrixXd MotionCovariance::operator()(const std::vector<Key>& keys) const {
  Eigen::Index dims = noise_.rows();
  for (const Key key : keys) dims += values_->type(key).dim;
  return (*this)(keys, Eigen::MatrixXd::Identity(dims, dims));
}

}  // namespace hybrid
