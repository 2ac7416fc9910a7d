// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, the hybrid mapping authors
#pragma once

#include <optional>
#include <vector>

#include "libhybrid/core/values.h"
#include "libhybrid/factors/factor.h"
#include "libhybrid/solvers/isotropic_form.h"

namespace HYBRID_API hybrid {

/// A minimum of the isotropic problem, and what its dual certificate proves; nothing if the
/// smallest eigenvalue is not found.
struct IsotropicMinimum {
  Eigen::MatrixXd Y;
  std::optional<DualBound> dual;
};

/// The minimum nearest to a point, with as many columns.
IsotropicMinimum isotropic_minimum(const IsotropicForm& form, const Eigen::MatrixXd& start);

/// Adds columns, at most three, until the certificate is tight (Riemannian staircase). Returns
/// their number.
int climb(const IsotropicForm& form, IsotropicMinimum& minimum);

/// A lower bound on the cost of relative poses over all poses, and the poses of the relaxation.
struct RelaxedPoses {
  double bound = 0.0;
  Values values;
};

/// By the isotropic problem of lower weights, from the poses given. Factors under a loss count as
/// nothing, as no such problem is below them. Throws Error as certify does.
RelaxedPoses relax_poses(const std::vector<ContinuousFactorPtr>& factors, const Values& start);

}  // namespace hybrid
