// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, the hybrid mapping authors
#include "libhybrid/solvers/isotropic_form.h"

#include <Spectra/SymEigsSolver.h>

#include <Eigen/SparseCholesky>
#include <algorithm>
#include <limits>
#include <vector>

namespace hybrid {
namespace {

constexpr int kShifts = 20;                // each ten times the one before
constexpr double kEigenvalueError = 1e-6;  // relative, of Lanczos iteration

/// M - Lambda.
Eigen::SparseMatrix<double> certificate_matrix(const IsotropicForm& form,
                                               const Eigen::MatrixXd& lambda) {
  std::vector<Eigen::Triplet<double>> triplets;
  for (int i = 0; i < form.poses; ++i) {
    for (int r = 0; r < form.d; ++r) {
      for (int c = 0; c < form.d; ++c) {
        triplets.emplace_back(form.rotation(i) + r, form.rotation(i) + c,
                              lambda(form.d * i + r, c));
      }
    }
  }
  Eigen::SparseMatrix<double> blocks(form.size(), form.size());
  blocks.setFromTriplets(triplets.begin(), triplets.end());
  return form.M - blocks;
}

/// (S + shift I)^-1 with the first variables of S eliminated.
class ShiftedInverse {
 public:
  using Scalar = double;

  ShiftedInverse(const Eigen::SparseMatrix<double>& S, int eliminated)
      : S_(S), eliminated_(eliminated) {}

  /// False if S + shift I is not positive definite.
  bool factorize(double shift) {
    Eigen::SparseMatrix<double> shifted = S_;
    for (Eigen::Index i = eliminated_; i < S_.rows(); ++i) shifted.coeffRef(i, i) += shift;
    ldlt_.compute(shifted);
    return ldlt_.info() == Eigen::Success && ldlt_.vectorD().minCoeff() > 0.0;
  }

  Eigen::Index rows() const { return S_.rows() - eliminated_; }
  Eigen::Index cols() const { return rows(); }
  void perform_op(const double* x, double* y) const {
    Eigen::Map<Eigen::VectorXd>(y, rows()) =
        with_eliminated(Eigen::Map<const Eigen::VectorXd>(x, rows())).tail(rows());
  }
  /// The solution for all variables.
  Eigen::VectorXd with_eliminated(const Eigen::VectorXd& x) const {
    Eigen::VectorXd b = Eigen::VectorXd::Zero(S_.rows());
    b.tail(rows()) = x;
    return ldlt_.solve(b);
  }

 private:
  const Eigen::SparseMatrix<double>& S_;
  int eliminated_;
  Eigen::SimplicialLDLT<Eigen::SparseMatrix<double>> ldlt_;
};

}  // namespace

double cost(const IsotropicForm& form, const Eigen::MatrixXd& Y) {
  return Y.cwiseProduct(form.M * Y).sum();
}

double rounding(const IsotropicForm& form, const Eigen::MatrixXd& Y) {
  return std::numeric_limits<double>::epsilon() *
         Y.rowwise().squaredNorm().dot(form.M.diagonal().cwiseAbs());
}

Eigen::MatrixXd multipliers(const IsotropicForm& form, const Eigen::MatrixXd& MY,
                            const Eigen::MatrixXd& Y) {
  Eigen::MatrixXd lambda(form.unknowns(), form.d);
  for (int i = 0; i < form.poses; ++i) {
    const Eigen::MatrixXd L = MY.middleRows(form.rotation(i), form.d) *
                              Y.middleRows(form.rotation(i), form.d).transpose();
    lambda.middleRows(form.d * i, form.d) = 0.5 * (L + L.transpose());
  }
  return lambda;
}

std::optional<DualBound> dual_bound(const IsotropicForm& form, const Eigen::MatrixXd& Y,
                                    double tolerance) {
  const Eigen::MatrixXd MY = form.M * Y;
  const Eigen::MatrixXd lambda = multipliers(form, MY, Y);
  const Eigen::SparseMatrix<double> S = certificate_matrix(form, lambda);
  ShiftedInverse inverse(S, form.translations());
  const double least = tolerance / form.unknowns();
  double shift = least;
  for (int tries = 0; !inverse.factorize(shift); ++tries) {
    if (tries >= kShifts) return std::nullopt;
    shift *= 10.0;
  }
  const int basis = static_cast<int>(std::min<Eigen::Index>(inverse.rows(), 30));
  Spectra::SymEigsSolver<ShiftedInverse> solver(inverse, 1, basis);
  solver.init();  // with a fixed seed
  solver.compute(Spectra::SortRule::LargestAlge, 1000, kEigenvalueError);
  if (solver.info() != Spectra::CompInfo::Successful) return std::nullopt;
  DualBound result;
  const double shifted = 1.0 / solver.eigenvalues()[0];
  result.min_eigenvalue = shifted - shift;
  const double least_possible = result.min_eigenvalue - kEigenvalueError * shifted;
  double dual = 0.0;
  for (int i = 0; i < form.poses; ++i) {
    dual += lambda.middleRows(form.d * i, form.d).trace();
  }
  result.bound = dual + form.unknowns() * std::min(0.0, least_possible);
  result.gap = Y.cwiseProduct(MY).sum() - result.bound;
  result.tight = result.gap <= tolerance;
  result.direction = inverse.with_eliminated(solver.eigenvectors().col(0)).normalized();
  return result;
}

}  // namespace hybrid
