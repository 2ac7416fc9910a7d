// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, the hybrid mapping authors
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "libhybrid/pose_graph/pose_graph.h"

namespace HYBRID_API hybrid {

/// The result of the verification of an estimate of a pose graph.
struct Certificate {
  bool verified = false;  ///< no other poses cost less, but for the gaps
  /// The same of the isotropic problem alone, if the noise of the factors is not isotropic or they
  /// have robust losses.
  bool isotropic_verified = false;
  double min_eigenvalue = 0.0;  ///< of the dual certificate matrix, see certify
  double relative_gap = 0.0;    ///< bound on how much less other poses cost, as a share of `cost`
  /// The same for the factors as stated, as a share of their cost; 1 if nothing is proven of them.
  double stated_gap = 1.0;
  double cost = 0.0;  ///< of the isotropic problem
  /// Bound on how much lower the joint objective is for other poses and decisions about closures,
  /// if there is one (see bound_objective); not set by certify.
  std::optional<double> discrete_gap;
  std::string message;  ///< why the estimate could not be verified; may be empty
};

/// Verifies that an estimate is in the basin of the global optimum, by the dual certificate of
/// SE-Sync (Rosen et al. 2019). It is computed for the isotropic problem, in which each relative
/// pose (R, t) among the factors, with covariance Sigma of its tangent, costs
///   kappa |R_j - R_i R|^2 + tau |t_j - t_i - R_i t|^2
/// with tau = d / tr(Sigma_t), and kappa half of the same for the rotation. The minimum of the
/// isotropic problem nearest to the estimate is computed first. There M Y = Lambda Y, with M the
/// matrix of the quadratic form and Lambda the multipliers of the rotations' orthogonality. No
/// other poses cost less if S = M - Lambda, translations eliminated, has no negative eigenvalue:
/// the cost of all others is at least `cost` + d n min_eigenvalue, for n poses. Factors with
/// isotropic noise and without a robust loss cost at least as much as in the isotropic problem, so
/// the bound holds for them; the difference is in `stated_gap`. It does not hold for other noise,
/// nor with losses, which are left out of the isotropic problem: then the estimate is at most
/// `isotropic_verified`. Neither is it verified if minimising the factors as stated from the
/// verified poses leads below its cost. Throws Error if no factor is a relative pose, if a factor
/// over several variables is none, or if values are missing.
Certificate certify(const std::vector<ContinuousFactorPtr>& factors, const Values& estimate);

/// The result of the Riemannian staircase.
struct StaircaseResult {
  Values values;                         ///< the estimate, or poses that cost less
  Certificate certificate;               ///< of these
  double cost_before = 0.0, cost = 0.0;  ///< of the factors as stated
  int levels = 0;                        ///< ranks tried above that of rotations
};

/// The same, and where the estimate is not verified, a search for poses that cost less by the
/// Riemannian staircase (Boumal 2015, Rosen et al. 2019): at a local minimum of the isotropic
/// problem, the eigenvector of the negative eigenvalue is a direction in which the cost falls if
/// rotations may have one more column, R in the Stiefel manifold St(d + 1, d). The problem is
/// minimised from there, for at most three further columns, until the certificate holds; then the
/// bound is the minimum of the relaxation, and `relative_gap` refers to it. Rounded to rotations,
/// the poses are the start of a solve of the factors as stated, whose result replaces the estimate
/// only if it costs less.
StaircaseResult climb_staircase(const std::vector<ContinuousFactorPtr>& factors,
                                const Values& estimate);

}  // namespace hybrid
