// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, the hybrid mapping authors
#include "libhybrid/factors/linear_prior.h"

#include <Eigen/Cholesky>
#include <cmath>
#include <memory>
#include <utility>

namespace hybrid {
namespace {

std::vector<VariableType> types_of(const std::vector<Key>& keys, const Values& points) {
  std::vector<VariableType> types;
  for (Key key : keys) types.push_back(points.type(key));
  return types;
}

/// Derivative of x boxminus x0 with respect to the tangent at x, where it has the value e.
Eigen::MatrixXd boxminus_jacobian(VariableType type, const double* e) {
  switch (type.kind) {
    case VariableKind::kSE2:
      return SE2::right_jacobian_inverse(Eigen::Map<const SE2::Tangent>(e));
    case VariableKind::kSO3:
      return SO3::right_jacobian_inverse(Eigen::Map<const SO3::Tangent>(e));
    case VariableKind::kSE3:
      return SE3::right_jacobian_inverse(Eigen::Map<const SE3::Tangent>(e));
    case VariableKind::kVector:
    case VariableKind::kSO2:
      break;
  }
  return Eigen::MatrixXd::Identity(type.dim, type.dim);
}

}  // namespace

LinearPrior::LinearPrior(const std::vector<Key>& keys, const Values& points, Eigen::MatrixXd R,
                         Eigen::VectorXd r)
    : ContinuousFactor(keys, types_of(keys, points), static_cast<int>(R.rows())),
      R_(std::move(R)),
      r_(std::move(r)) {
  for (Key key : keys) {
    const double* x = points.data(key);
    points_.insert(points_.end(), x, x + points.type(key).size);
  }
  if (R_.cols() != cols() || r_.size() != R_.rows())
    throw Error("a linear prior has matrices that do not fit");
}

ContinuousFactorPtr LinearPrior::from_information(const std::vector<Key>& keys,
                                                  const Values& points,
                                                  const Eigen::MatrixXd& information,
                                                  const Eigen::VectorXd& gradient) {
  // Lambda = P' L D L' P with pivoting; directions without information drop out.
  const Eigen::LDLT<Eigen::MatrixXd> ldlt(information);
  const Eigen::VectorXd d = ldlt.vectorD();
  const double least = 1e-12 * d.cwiseAbs().maxCoeff();
  int rank = 0;
  while (rank < d.size() && d[rank] > least) ++rank;
  const Eigen::MatrixXd lower = ldlt.matrixL();
  const Eigen::VectorXd root = d.head(rank).cwiseSqrt();
  const Eigen::MatrixXd transposed =
      ldlt.transpositionsP().transpose() * (lower.leftCols(rank) * root.asDiagonal());
  Eigen::VectorXd y = ldlt.transpositionsP() * gradient;
  ldlt.matrixL().solveInPlace(y);
  const Eigen::VectorXd r = y.head(rank).cwiseQuotient(root);
  return std::make_shared<LinearPrior>(keys, points, transposed.transpose(), r);
}

Eigen::VectorXd LinearPrior::tangent(const double* const* x) const {
  Eigen::VectorXd e(cols());
  int row = 0;
  int at = 0;
  for (std::size_t i = 0; i < types().size(); ++i) {
    local(types()[i], points_.data() + at, x[i], e.data() + row);
    row += types()[i].dim;
    at += types()[i].size;
  }
  return e;
}

double LinearPrior::cost(const double* const* x) const {
  return 0.5 * (R_ * tangent(x) + r_).squaredNorm();
}

double LinearPrior::linearize(const double* const* x, double* r, double* J) const {
  const Eigen::VectorXd e = tangent(x);
  Eigen::Map<Eigen::VectorXd> residual(r, rows());
  Eigen::Map<Eigen::MatrixXd> jacobian(J, rows(), cols());
  residual = R_ * e + r_;
  int column = 0;
  for (const VariableType& type : types()) {
    jacobian.middleCols(column, type.dim) =
        R_.middleCols(column, type.dim) * boxminus_jacobian(type, e.data() + column);
    column += type.dim;
  }
  return 0.5 * residual.squaredNorm();
}

}  // namespace hybrid
