// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, the hybrid mapping authors
#include "libhybrid/marginals/detail/outside.h"

#include <Eigen/Eigenvalues>
#include <memory>

#include "libhybrid/factors/linear_prior.h"

namespace hybrid {
namespace {

/// Least variance of a direction that is more than rounding, per dimension, over variables of unit
/// variance.
constexpr double kRounding = 1e-14;
/// If all but this share of the information on a direction is from the sites, the rest has none.
constexpr double kNothing = 1e-9;
/// Information below minus this is no rounding error of zero.
constexpr double kWrong = 1e-3;

}  // namespace

// In coordinates x = T y with Sigma = T T' the whole information on y is the identity, and that of
// the rest, I - T' J'J T, has its eigenvalues between zero and one, so that the subtraction loses
// no digits that matter.
ContinuousFactorPtr outside_prior(const JointGaussian& gaussian, const std::vector<Site>& sites) {
  const int n = gaussian.size();
  const Eigen::VectorXd sigmas = gaussian.covariance.diagonal().cwiseSqrt();
  if (!(sigmas.minCoeff() > 0.0)) throw Error("a variable has no variance");
  const Eigen::VectorXd scale = sigmas.cwiseInverse();
  const Eigen::SelfAdjointEigenSolver<Eigen::MatrixXd> correlation(
      scale.asDiagonal() * gaussian.covariance * scale.asDiagonal());
  const Eigen::VectorXd roots = correlation.eigenvalues().cwiseMax(n * kRounding).cwiseSqrt();
  const Eigen::MatrixXd T = sigmas.asDiagonal() * correlation.eigenvectors() * roots.asDiagonal();
  const Eigen::MatrixXd T_inverse = roots.cwiseInverse().asDiagonal() *
                                    correlation.eigenvectors().transpose() * scale.asDiagonal();
  Eigen::MatrixXd information = Eigen::MatrixXd::Identity(n, n);
  Eigen::VectorXd gradient = Eigen::VectorXd::Zero(n);
  for (const Site& site : sites) {
    const LinearRows rows = linear_rows(site.factors[site.present], gaussian);
    const Eigen::MatrixXd A = rows.J * T;
    information -= A.transpose() * A;
    gradient -= A.transpose() * rows.r;
  }
  const Eigen::SelfAdjointEigenSolver<Eigen::MatrixXd> outside(information);
  if (outside.eigenvalues()[0] < -kWrong) {
    throw Error("the covariance of " + to_string(gaussian.keys[0]) +
                " and others has too large rounding errors to take factors out of it");
  }
  int unknown = 0;
  while (unknown < n && outside.eigenvalues()[unknown] < kNothing) ++unknown;
  if (unknown == n) return nullptr;
  const Eigen::VectorXd root = outside.eigenvalues().tail(n - unknown).cwiseSqrt();
  const auto directions = outside.eigenvectors().rightCols(n - unknown).transpose();
  const Eigen::VectorXd r = root.cwiseInverse().asDiagonal() * (directions * gradient);
  return std::make_shared<LinearPrior>(gaussian.keys, *gaussian.values,
                                       root.asDiagonal() * directions * T_inverse, r);
}

}  // namespace hybrid
