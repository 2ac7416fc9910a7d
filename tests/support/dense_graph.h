// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, the hybrid mapping authors
#pragma once

#include <Eigen/Cholesky>
#include <Eigen/Core>
#include <unordered_map>

#include "libhybrid/hybrid/graph.h"

namespace hybrid::testing {

/// J'J of all chosen components, weak ones included, at an estimate: dense, the variables in the
/// order of their slots.
inline Eigen::MatrixXd dense_information(const HybridGraph& graph, const Estimate& estimate) {
  std::unordered_map<Key, int> start;
  int n = 0;
  for (Key key : estimate.values.keys()) {
    start[key] = n;
    n += estimate.values.type(key).dim;
  }
  Eigen::MatrixXd information = Eigen::MatrixXd::Zero(n, n);
  const auto add = [&](const ContinuousFactor* factor) {
    if (factor == nullptr) return;
    Eigen::VectorXd r(factor->rows());
    Eigen::MatrixXd J(factor->rows(), factor->cols());
    factor->linearize(gather(factor->keys(), factor->types(), estimate.values).data(), r.data(),
                      J.data());
    Eigen::MatrixXd wide = Eigen::MatrixXd::Zero(factor->rows(), n);
    int col = 0;
    for (std::size_t i = 0; i < factor->keys().size(); ++i) {
      const int dim = factor->types()[i].dim;
      wide.middleCols(start[factor->keys()[i]], dim) += J.middleCols(col, dim);
      col += dim;
    }
    information += wide.transpose() * wide;
  };
  graph.continuous().for_each([&](Handle, const auto& factor) { add(factor.get()); });
  graph.hybrid().for_each(
      [&](Handle, const auto& factor) { add(factor->given(estimate.assignment).factor); });
  return information;
}

/// log det of a symmetric positive definite matrix.
inline double log_determinant(const Eigen::MatrixXd& m) {
  return 2.0 * Eigen::MatrixXd(m.llt().matrixL()).diagonal().array().log().sum();
}

}  // namespace hybrid::testing
