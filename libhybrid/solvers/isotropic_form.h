// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, the hybrid mapping authors
#pragma once

#include <Eigen/Core>
#include <Eigen/SparseCore>
#include <optional>

#include "libhybrid/geometry/eigen.h"

namespace HYBRID_API hybrid {

/// The isotropic problem of n poses as a quadratic form (Rosen et al. 2019): minimise tr(Y' M Y),
/// where Y stacks the translations of all poses but the first, which is at the origin, as rows,
/// then the transposed rotations, d rows each. With more than d columns Y is a lifted point: the
/// rows of a rotation stay orthonormal.
struct IsotropicForm {
  int d = 0;      ///< 2 or 3
  int poses = 0;  ///< n
  Eigen::SparseMatrix<double> M;

  int translations() const { return poses - 1; }
  int unknowns() const { return d * poses; }  ///< rows of the rotations
  int size() const { return translations() + unknowns(); }
  int rotation(int pose) const { return translations() + d * pose; }  ///< its first row
};

/// tr(Y' M Y).
double cost(const IsotropicForm& form, const Eigen::MatrixXd& Y);

/// Size of the rounding errors of the cost at Y.
double rounding(const IsotropicForm& form, const Eigen::MatrixXd& Y);

/// The multipliers of the orthonormality of the rotations at Y, d rows and columns of each pose:
/// the symmetric part of (M Y)_i Y_i'.
Eigen::MatrixXd multipliers(const IsotropicForm& form, const Eigen::MatrixXd& MY,
                            const Eigen::MatrixXd& Y);

/// What the dual certificate proves at a point.
struct DualBound {
  double min_eigenvalue = 0.0;  ///< of S = M - Lambda with the translations eliminated
  double gap = 0.0;             ///< between the cost of the point and the bound
  /// No rotations and translations, lifted or not, cost less: tr(Lambda) plus the eigenvalue, if it
  /// is negative, times the unknowns.
  double bound = 0.0;
  bool tight = false;         ///< the gap is within the tolerance
  Eigen::VectorXd direction;  ///< in which a further column lowers the cost, if it is not
};

/// The bound at Y. `tolerance` is the smallest difference of costs that matters. Empty if the
/// smallest eigenvalue is not found.
std::optional<DualBound> dual_bound(const IsotropicForm& form, const Eigen::MatrixXd& Y,
                                    double tolerance);

}  // namespace hybrid
