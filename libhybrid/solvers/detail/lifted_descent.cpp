// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, the hybrid mapping authors
#include "libhybrid/solvers/detail/lifted_descent.h"

#include <Eigen/Eigenvalues>
#include <Eigen/SVD>
#include <Eigen/SparseCholesky>
#include <algorithm>
#include <cmath>
#include <utility>

namespace hybrid {
namespace {

using Eigen::MatrixXd;

constexpr int kOuterSteps = 100;
constexpr int kInnerSteps = 200;
constexpr double kInnerDecrease = 1e-3;      // of the preconditioned gradient
constexpr double kRelativeDecrease = 1e-14;  // predicted, of the cost: converged
constexpr double kRegularization = 1e-6;  // of M for the preconditioner, relative to its diagonal
constexpr double kRoundings = 10.0;       // smaller decreases of the cost may be rounding errors
constexpr int kHalvings = 40;

double inner(const MatrixXd& a, const MatrixXd& b) {
  return a.cwiseProduct(b).sum();
}

/// The factor (I + Z Z')^(-1/2) (Y + Z) for a tangent Z: the polar retraction of one rotation.
MatrixXd polar(const MatrixXd& A) {
  const Eigen::SelfAdjointEigenSolver<MatrixXd> gram(A * A.transpose());
  return gram.operatorInverseSqrt() * A;
}

MatrixXd retract(const IsotropicForm& form, const MatrixXd& Y, const MatrixXd& step) {
  MatrixXd moved = Y + step;
  for (int i = 0; i < form.poses; ++i) {
    const int row = form.rotation(i);
    moved.middleRows(row, form.d) = polar(moved.middleRows(row, form.d));
  }
  return moved;
}

/// Cost, gradient and Hessian at a point of the manifold.
class LiftedPoint {
 public:
  LiftedPoint(const IsotropicForm& form, MatrixXd Y) : form_(&form), Y_(std::move(Y)) {
    const MatrixXd MY = form.M * Y_;
    cost_ = inner(Y_, MY);
    lambda_ = multipliers(form, MY, Y_);
    gradient_ = 2.0 * (MY - multiplied(Y_));
  }

  const MatrixXd& Y() const { return Y_; }
  double cost() const { return cost_; }
  const MatrixXd& gradient() const { return gradient_; }
  MatrixXd hessian(const MatrixXd& Z) const {
    return tangent(2.0 * (form_->M * Z - multiplied(Z)));
  }
  /// The projection onto the tangent space.
  MatrixXd tangent(MatrixXd Z) const {
    for (int i = 0; i < form_->poses; ++i) {
      const auto Yi = Y_.middleRows(form_->rotation(i), form_->d);
      auto Zi = Z.middleRows(form_->rotation(i), form_->d);
      const MatrixXd L = Zi * Yi.transpose();
      Zi -= 0.5 * (L + L.transpose()) * Yi;
    }
    return Z;
  }

 private:
  MatrixXd multiplied(const MatrixXd& Z) const {
    MatrixXd product = MatrixXd::Zero(Z.rows(), Z.cols());
    for (int i = 0; i < form_->poses; ++i) {
      product.middleRows(form_->rotation(i), form_->d) =
          lambda_.middleRows(form_->d * i, form_->d) * Z.middleRows(form_->rotation(i), form_->d);
    }
    return product;
  }

  const IsotropicForm* form_;
  MatrixXd Y_, lambda_, gradient_;
  double cost_ = 0.0;
};

/// M regularised, the preconditioner of the Hessian.
class Preconditioner {
 public:
  explicit Preconditioner(const IsotropicForm& form) {
    Eigen::SparseMatrix<double> regular = 2.0 * form.M;
    const double shift = kRegularization * regular.diagonal().maxCoeff();
    for (int i = form.translations(); i < form.size(); ++i) regular.coeffRef(i, i) += shift;
    ldlt_.compute(regular);
  }
  bool usable() const { return ldlt_.info() == Eigen::Success; }
  MatrixXd solve(const MatrixXd& b) const { return ldlt_.solve(b); }

 private:
  Eigen::SimplicialLDLT<Eigen::SparseMatrix<double>> ldlt_;
};

/// A step and its image under the Hessian.
struct Step {
  MatrixXd step, image;
  bool at_boundary = false;

  double predicted_decrease(const LiftedPoint& at) const {
    return -inner(at.gradient(), step) - 0.5 * inner(step, image);
  }
};

/// Truncated conjugate gradients (Steihaug) within `radius`, in the norm of the preconditioner.
Step truncated_newton(const LiftedPoint& at, const Preconditioner& preconditioner, double radius) {
  Step result{MatrixXd::Zero(at.Y().rows(), at.Y().cols()),
              MatrixXd::Zero(at.Y().rows(), at.Y().cols())};
  MatrixXd r = at.gradient();
  MatrixXd z = at.tangent(preconditioner.solve(r));
  MatrixXd delta = -z;
  double rz = inner(r, z);
  const double enough = kInnerDecrease * kInnerDecrease * rz;
  double step_step = 0.0, step_delta = 0.0, delta_delta = rz;
  for (int k = 0; k < kInnerSteps && rz > enough; ++k) {
    const MatrixXd image = at.hessian(delta);
    const double curvature = inner(delta, image);
    const double alpha = rz / curvature;
    const double longer = step_step + 2.0 * alpha * step_delta + alpha * alpha * delta_delta;
    if (!(curvature > 0.0) || longer >= radius * radius) {
      const double room = radius * radius - step_step;
      const double to_boundary =
          (-step_delta + std::sqrt(step_delta * step_delta + delta_delta * room)) / delta_delta;
      result.step += to_boundary * delta;
      result.image += to_boundary * image;
      result.at_boundary = true;
      return result;
    }
    result.step += alpha * delta;
    result.image += alpha * image;
    step_step = longer;
    r += alpha * image;
    z = at.tangent(preconditioner.solve(r));
    const double before = rz;
    rz = inner(r, z);
    const double beta = rz / before;
    delta = beta * delta - z;
    step_delta = beta * (step_delta + alpha * delta_delta);
    delta_delta = rz + beta * beta * delta_delta;
  }
  return result;
}

}  // namespace

MatrixXd nearest_minimum(const IsotropicForm& form, MatrixXd Y) {
  const Preconditioner preconditioner(form);
  if (!preconditioner.usable()) return Y;
  const auto squared_gradient = [&](const LiftedPoint& at) {
    return inner(at.gradient(), at.tangent(preconditioner.solve(at.gradient())));
  };
  LiftedPoint at(form, std::move(Y));
  double slope = squared_gradient(at);
  double radius = std::sqrt(slope);
  for (int k = 0; k < kOuterSteps && slope > kRelativeDecrease * at.cost(); ++k) {
    const Step step = truncated_newton(at, preconditioner, radius);
    const double predicted = step.predicted_decrease(at);
    LiftedPoint next(form, retract(form, at.Y(), step.step));
    const double next_slope = squared_gradient(next);
    const double ratio = (at.cost() - next.cost()) / predicted;
    if (predicted < kRoundings * rounding(form, at.Y())) {
      // Costs cannot be told apart any more, gradients can.
      if (!(next_slope < slope)) break;
    } else {
      if (!(ratio > 0.25)) radius *= 0.25;
      if (ratio > 0.75 && step.at_boundary) radius *= 2.0;
      if (!(ratio > 0.1)) continue;
    }
    at = std::move(next);
    slope = next_slope;
  }
  return at.Y();
}

MatrixXd lifted(const IsotropicForm& form, const MatrixXd& Y, const Eigen::VectorXd& direction) {
  MatrixXd saddle = MatrixXd::Zero(Y.rows(), Y.cols() + 1);
  saddle.leftCols(Y.cols()) = Y;
  MatrixXd step = MatrixXd::Zero(Y.rows(), Y.cols() + 1);
  step.rightCols(1) = direction;
  const double here = cost(form, Y);
  double length = std::sqrt(double(form.unknowns()));  // every rotation by about a radian
  for (int k = 0; k < kHalvings; ++k, length *= 0.5) {
    MatrixXd moved = retract(form, saddle, length * step);
    if (cost(form, moved) < here) return moved;
  }
  return Y;
}

MatrixXd rounded(const IsotropicForm& form, const MatrixXd& Y) {
  const int d = form.d;
  const MatrixXd rotations = Y.bottomRows(form.unknowns());
  const Eigen::SelfAdjointEigenSolver<MatrixXd> gram(rotations.transpose() * rotations);
  MatrixXd result = Y * gram.eigenvectors().rightCols(d);
  int reflected = 0;
  for (int i = 0; i < form.poses; ++i) {
    if (result.middleRows(form.rotation(i), d).determinant() < 0.0) ++reflected;
  }
  if (2 * reflected > form.poses) result.col(0) *= -1.0;
  for (int i = 0; i < form.poses; ++i) {
    const MatrixXd block = result.middleRows(form.rotation(i), d);
    const Eigen::JacobiSVD<MatrixXd> svd(block, Eigen::ComputeFullU | Eigen::ComputeFullV);
    Eigen::VectorXd signs = Eigen::VectorXd::Ones(d);
    signs[d - 1] = (svd.matrixU() * svd.matrixV().transpose()).determinant();
    result.middleRows(form.rotation(i), d) =
        svd.matrixU() * signs.asDiagonal() * svd.matrixV().transpose();
  }
  return result;
}

}  // namespace hybrid
