// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, the hybrid mapping authors
#pragma once

#include <string>
#include <vector>

#include "libhybrid/pose_graph/pose_graph.h"

namespace HYBRID_API hybrid {

/// What is proven of an estimate of a pose graph.
struct Certificate {
  bool verified = false;        ///< no other poses cost less, but for `relative_gap`
  double min_eigenvalue = 0.0;  ///< of the dual certificate matrix, see certify
  double relative_gap = 0.0;    ///< by how much less poses might cost, as a share of `cost`
  double cost = 0.0;            ///< of the isotropic problem
  std::string message;          ///< where nothing could be computed
};

/// Verifies that an estimate lies in the basin of the global optimum, by the dual certificate of
/// SE-Sync (Rosen et al. 2019). Of each relative pose (R, t) among the factors with information
/// over its tangent, the isotropic problem takes
///   kappa |R_j - R_i R|^2 + tau |t_j - t_i - R_i t|^2
/// with tau = d / tr(Sigma_t), and kappa half of the same for the rotation. The estimate is brought
/// to the minimum of that nearest to it. There M Y = Lambda Y, with M the matrix of the quadratic
/// form and Lambda the multipliers of the rotations' orthogonality; and no other poses cost less if
/// S = M - Lambda, translations eliminated, has no negative eigenvalue: the cost of all others is
/// at least `cost` + d n min_eigenvalue, for n poses. It says nothing of costs that are not
/// isotropic, but that the estimate is where the factors as stated end from the verified poses,
/// else it is not verified. Throws Error where no factor is a relative pose, one is over several
/// variables and none, or values are missing.
Certificate certify(const std::vector<ContinuousFactorPtr>& factors, const Values& estimate);

}  // namespace hybrid
