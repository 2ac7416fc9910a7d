// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, the hybrid mapping authors
#include "libhybrid/marginals/detail/site.h"

#include <string>
#include <utility>

#include "libhybrid/factors/linear_at.h"

namespace hybrid {

JointGaussian::JointGaussian(std::vector<Key> variables, Eigen::MatrixXd joint_covariance,
                             const Values& estimate)
    : keys(std::move(variables)), covariance(std::move(joint_covariance)), values(&estimate) {
  int rows = 0;
  for (Key key : keys) {
    place.emplace(key, rows);
    rows += estimate.type(key).dim;
  }
  if (covariance.rows() != rows || covariance.cols() != rows) {
    throw Error("a covariance of " + std::to_string(covariance.rows()) + " rows for variables of " +
                std::to_string(rows) + " dimensions");
  }
}

LinearRows linear_rows(const ContinuousFactor* factor, const JointGaussian& gaussian) {
  if (factor == nullptr) return {Eigen::VectorXd(0), Eigen::MatrixXd(0, gaussian.size())};
  const auto [residual, J] = linear_at(*factor, *gaussian.values);
  LinearRows rows{residual, Eigen::MatrixXd::Zero(factor->rows(), gaussian.size())};
  int column = 0;
  for (std::size_t i = 0; i < factor->keys().size(); ++i) {
    const auto at = gaussian.place.find(factor->keys()[i]);
    if (at == gaussian.place.end()) {
      throw Error("variable " + to_string(factor->keys()[i]) + " of a " + factor->name() +
                  " factor has no covariance");
    }
    const int dim = factor->types()[i].dim;
    rows.J.middleCols(at->second, dim) += J.middleCols(column, dim);
    column += dim;
  }
  return rows;
}

}  // namespace hybrid
