// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, the hybrid mapping authors

#pragma once

#include <Eigen/Cholesky>
#include <Eigen/Eigenvalues>

#include "libhybrid/geometry/eigen.h"

namespace HYBRID_API hybrid {

/// Error of the direction of a surface as few returns tell it [rad]. Walls of a corridor alone seem
/// to tell the place along it by that much.
inline constexpr double kDirectionError = 0.05;
/// The least share of the information in a direction that is taken to be of surfaces, not of the
/// errors of their directions.
inline constexpr double kLeastShare = 0.01;

/// The share S of the information `H` of surfaces about a pose that is not of errors of their
/// directions, which add about `F` to it: S H is the information without them, S g the gradient.
/// Zero where H is not positive definite.
template <int N>
Eigen::Matrix<double, N, N> share_of_surfaces(const Eigen::Matrix<double, N, N>& H,
                                              const Eigen::Matrix<double, N, N>& F) {
  using Matrix = Eigen::Matrix<double, N, N>;
  const Eigen::LLT<Matrix> factor(H);
  if (factor.info() != Eigen::Success) return Matrix::Zero();
  const Matrix L = factor.matrixL();
  Matrix A = factor.matrixL().solve(F);
  A = factor.matrixL().solve(A.transpose().eval());
  const Eigen::SelfAdjointEigenSolver<Matrix> eigen(0.5 * (A + A.transpose()));
  // Twice: the errors add this much on average.
  const Eigen::Matrix<double, N, 1> shares =
      (1.0 - 2.0 * eigen.eigenvalues().array()).cwiseMax(kLeastShare).matrix();
  const Matrix B = L * eigen.eigenvectors();
  const Matrix back =
      eigen.eigenvectors().transpose() * Matrix(factor.matrixL().solve(Matrix::Identity()));
  return B * shares.asDiagonal() * back;
}

/// Information `H` of surfaces about a pose without errors of their directions, where `share` is
/// that of share_of_surfaces; symmetric to the last bit.
template <int N>
Eigen::Matrix<double, N, N> without_direction_errors(const Eigen::Matrix<double, N, N>& share,
                                                     const Eigen::Matrix<double, N, N>& H) {
  const Eigen::Matrix<double, N, N> known = share * H;
  return 0.5 * (known + known.transpose());
}

}  // namespace hybrid
