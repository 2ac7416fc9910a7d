// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, the hybrid mapping authors
#include "libhybrid/selection/prediction.h"

#include <Eigen/Cholesky>

namespace hybrid {

Prediction predict_measurement(const ContinuousFactor& factor, const double* const* x,
                               const Eigen::MatrixXd& P) {
  const int rows = factor.rows();
  Eigen::VectorXd b(rows);
  Eigen::MatrixXd A(rows, factor.cols());
  factor.linearize(x, b.data(), A.data());
  const Eigen::MatrixXd S = Eigen::MatrixXd::Identity(rows, rows) + A * P * A.transpose();
  const Eigen::LLT<Eigen::MatrixXd> llt(S);
  Prediction innovation;
  innovation.information = llt.solve(Eigen::MatrixXd::Identity(rows, rows));
  innovation.chi_square = b.dot(innovation.information * b);
  const Eigen::MatrixXd L = llt.matrixL();
  innovation.log_determinant = 2.0 * L.diagonal().array().log().sum();
  innovation.redundancy = innovation.information.trace() / rows;
  return innovation;
}

double joined_redundancy(const ContinuousFactor& factor, const double* const* x,
                         const Eigen::MatrixXd& P) {
  Eigen::VectorXd b(factor.rows());
  Eigen::MatrixXd A(factor.rows(), factor.cols());
  factor.linearize(x, b.data(), A.data());
  return 1.0 - (A * P).cwiseProduct(A).sum() / factor.rows();
}

double chi_square_under(const ContinuousFactor& factor, const double* const* x,
                        const Eigen::MatrixXd& W) {
  Eigen::VectorXd b(factor.rows());
  Eigen::MatrixXd A(factor.rows(), factor.cols());
  factor.linearize(x, b.data(), A.data());
  return b.dot(W * b);
}

}  // namespace hybrid
