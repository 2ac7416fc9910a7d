// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, the hybrid mapping authors
#pragma once

#include <vector>

#include "libhybrid/core/values.h"
#include "libhybrid/factors/factor.h"
#include "libhybrid/geometry/se2.h"
#include "libhybrid/geometry/se3.h"
#include "libhybrid/solvers/isotropic_form.h"

namespace hybrid {

/// A relative pose of the isotropic problem, see certify.
template <class Pose>
struct IsotropicEdge {
  Key from, to;
  int i = 0, j = 0;  ///< numbers of the poses
  Pose measured;
  double kappa = 1.0, tau = 1.0;  ///< weights of rotation and translation
  bool is_bound = false;          ///< twice the cost of the factor is nowhere below the edge's
};

/// How the information of a relative pose becomes isotropic. Twice the cost of a factor is near the
/// cost of its edge with mean weights, and never below it with lower ones, for which factors under
/// a loss are left out.
enum class IsotropicWeights {
  kMean,  ///< tau = d / tr(Sigma_t), and kappa half of the same for the rotation
  kLower  ///< the largest of the same ratio that are below the information in every direction;
          ///< then the edge is below the factor, as |R - I|^2 <= 2 |log R|^2, and the translation
          ///< of a logarithm is no shorter than that of the motion
};

/// The relative poses among the factors. Poses are numbered as they appear. Throws Error if a
/// factor over several variables measures no relative pose.
template <class Pose>
std::vector<IsotropicEdge<Pose>> relative_poses(const std::vector<ContinuousFactorPtr>& factors,
                                                IsotropicWeights weights = IsotropicWeights::kMean);

template <class Pose>
IsotropicForm isotropic_form(const std::vector<IsotropicEdge<Pose>>& graph);

/// The poses as a point of the form.
template <class Pose>
Eigen::MatrixXd stacked(const std::vector<IsotropicEdge<Pose>>& graph, const Values& poses);

/// The values with the poses of a point of the form that has d columns, moved so that `reference`
/// stays where it is.
template <class Pose>
Values unstacked(const std::vector<IsotropicEdge<Pose>>& graph, const Eigen::MatrixXd& Y,
                 Key reference, Values values);

}  // namespace hybrid
