// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, the hybrid mapping authors
#include "libhybrid/core/noise.h"

#include <Eigen/Cholesky>
#include <Eigen/LU>
#include <cmath>
#include <string>
#include <utility>

#include "libhybrid/core/error.h"

namespace hybrid {
namespace {

constexpr int kMostDim = 4096;  // a matrix of 128 MB
constexpr double kLog2Pi = 1.8378770664093454836;

void check_symmetric(const Eigen::MatrixXd& m, const char* name) {
  if (m.rows() != m.cols() || m.rows() == 0) {
    throw Error(std::string(name) + " must be square, got " + std::to_string(m.rows()) + " x " +
                std::to_string(m.cols()));
  }
  if (!m.allFinite()) throw Error(std::string(name) + " has an entry that is not finite");
  const double scale = m.cwiseAbs().maxCoeff();
  if ((m - m.transpose()).cwiseAbs().maxCoeff() > 1e-6 * scale) {
    throw Error(std::string(name) + " must be symmetric");
  }
}

}  // namespace

Noise::Noise(Eigen::MatrixXd sqrt_information) : sqrt_information_(std::move(sqrt_information)) {
  log_normalizer_ = 0.5 * kLog2Pi * dim();
  for (int i = 0; i < dim(); ++i) log_normalizer_ -= std::log(std::abs(sqrt_information_(i, i)));
}

Noise Noise::isotropic(int dim, double sigma) {
  if (dim < 1 || dim > kMostDim) {
    throw Error("noise may have 1 to " + std::to_string(kMostDim) + " dimensions, got " +
                std::to_string(dim));
  }
  return diagonal(Eigen::VectorXd::Constant(dim, sigma));
}

Noise Noise::diagonal(const Eigen::VectorXd& sigmas) {
  if (sigmas.size() == 0) throw Error("noise needs at least one standard deviation");
  for (int i = 0; i < sigmas.size(); ++i) {
    if (!(sigmas[i] > 0.0) || !std::isfinite(sigmas[i])) {
      throw Error("standard deviation " + std::to_string(i) + " must be positive and finite, got " +
                  std::to_string(sigmas[i]));
    }
  }
  return Noise(Eigen::MatrixXd(sigmas.cwiseInverse().asDiagonal()));
}

Noise Noise::information(const Eigen::MatrixXd& information) {
  check_symmetric(information, "information matrix");
  const Eigen::LLT<Eigen::MatrixXd> llt(information);
  if (llt.info() != Eigen::Success) throw Error("information matrix is not positive definite");
  return Noise(Eigen::MatrixXd(llt.matrixU()));
}

Noise Noise::covariance(const Eigen::MatrixXd& covariance) {
  check_symmetric(covariance, "covariance matrix");
  // Sigma = U U' with U upper triangular gives R = U^-1, upper triangular; U comes from the
  // Cholesky factorisation of the matrix with its rows and columns reversed.
  const Eigen::LLT<Eigen::MatrixXd> llt(covariance.reverse());
  if (llt.info() != Eigen::Success) throw Error("covariance matrix is not positive definite");
  const Eigen::MatrixXd u = Eigen::MatrixXd(llt.matrixL()).reverse();
  return Noise(u.triangularView<Eigen::Upper>().solve(
      Eigen::MatrixXd::Identity(covariance.rows(), covariance.cols())));
}

Eigen::MatrixXd Noise::covariance() const {
  const Eigen::MatrixXd inverse = sqrt_information_.triangularView<Eigen::Upper>().solve(
      Eigen::MatrixXd::Identity(dim(), dim()));
  return inverse * inverse.transpose();
}

Noise Noise::inflated(double factor) const {
  if (!(factor > 0.0) || !std::isfinite(factor)) {
    throw Error("covariance factor must be positive and finite, got " + std::to_string(factor));
  }
  return Noise(sqrt_information_ / std::sqrt(factor));
}

Eigen::MatrixXd Noise::information() const {
  return sqrt_information_.transpose() * sqrt_information_;
}

}  // namespace hybrid
