// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, the hybrid mapping authors
#pragma once

#include "libhybrid/solvers/isotropic_form.h"

namespace hybrid {

/// The minimum of the isotropic problem nearest to Y, with as many columns as Y: the Riemannian
/// trust-region method with truncated conjugate gradients (Absil, Baker, Gallivan 2007) on the
/// Stiefel manifold of each rotation, preconditioned by the Cholesky factor of M. The cost never
/// rises by more than rounding errors.
Eigen::MatrixXd nearest_minimum(const IsotropicForm& form, Eigen::MatrixXd Y);

/// Y with a further column along `direction`, in which the cost falls from the saddle Y. Without
/// the column, if it falls for no step length.
Eigen::MatrixXd lifted(const IsotropicForm& form, const Eigen::MatrixXd& Y,
                       const Eigen::VectorXd& direction);

/// The proper rotations, and the translations, nearest to Y in the subspace of d columns that holds
/// most of its rotations.
Eigen::MatrixXd rounded(const IsotropicForm& form, const Eigen::MatrixXd& Y);

}  // namespace hybrid
