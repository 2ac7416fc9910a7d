// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, the hybrid mapping authors
#pragma once

#include <Eigen/Core>
#include <Eigen/QR>
#include <algorithm>
#include <unordered_map>
#include <vector>

#include "libhybrid/hybrid/graph.h"

namespace hybrid::testing {

/// The residuals of all active factors at an estimate, and their Jacobian, with variables in the
/// order of their slots.
struct DenseSystem {
  Eigen::VectorXd r;
  Eigen::MatrixXd J;
  double cost = 0.0;

  DenseSystem(const HybridGraph& graph, const Estimate& estimate) {
    int n = 0;
    for (Key key : estimate.values.keys()) {
      start[key] = n;
      n += estimate.values.type(key).dim;
    }
    J.resize(0, n);
    graph.continuous().for_each([&](Handle, const auto& factor) { add(*factor, estimate.values); });
    graph.hybrid().for_each([&](Handle, const HybridFactorPtr& factor) {
      const Component component = factor->given(estimate.assignment);
      if (component.factor != nullptr) add(*component.factor, estimate.values);
    });
  }

  /// Predicted decrease of the cost by a Gauss-Newton step: half the squared norm of the projection
  /// of r onto the columns of J. Zero at a stationary point, independent of frames and units.
  double promise() const {
    Eigen::VectorXd scale = J.colwise().norm();
    for (double& x : scale) x = x > 0.0 ? 1.0 / x : 0.0;
    const Eigen::MatrixXd scaled = J * scale.asDiagonal();
    const Eigen::CompleteOrthogonalDecomposition<Eigen::MatrixXd> qr(scaled);
    return 0.5 * (scaled * qr.solve(r)).squaredNorm();
  }

  std::unordered_map<Key, int> start;

 private:
  void add(const ContinuousFactor& factor, const Values& values) {
    Eigen::VectorXd residual(factor.rows());
    Eigen::MatrixXd jacobian(factor.rows(), factor.cols());
    cost += factor.linearize(gather(factor.keys(), factor.types(), values).data(), residual.data(),
                             jacobian.data());
    const Eigen::Index row = J.rows();
    J.conservativeResize(row + factor.rows(), Eigen::NoChange);
    r.conservativeResize(row + factor.rows());
    J.bottomRows(factor.rows()).setZero();
    r.tail(factor.rows()) = residual;
    int col = 0;
    for (std::size_t i = 0; i < factor.keys().size(); ++i) {
      const int dim = factor.types()[i].dim;
      J.block(row, start.at(factor.keys()[i]), factor.rows(), dim) = jacobian.middleCols(col, dim);
      col += dim;
    }
  }
};

}  // namespace hybrid::testing
