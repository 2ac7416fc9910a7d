// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, the hybrid mapping authors
#pragma once

#include <Eigen/Core>
#include <unordered_map>
#include <vector>

#include "libhybrid/core/values.h"
#include "libhybrid/factors/factor.h"

namespace hybrid {

/// A place in a graph for one of several alternative factors.
struct Site {
  std::vector<const ContinuousFactor*> factors;  ///< null for none
  int present = 0;  ///< index of the factor that the joint Gaussian includes
};

/// The Gaussian of some continuous variables at an estimate (eq. 11b), over their tangents. Its
/// mean is the estimate, which minimises L.
struct JointGaussian {
  /// Throws Error unless the covariance is of the size of the variables.
  JointGaussian(std::vector<Key> variables, Eigen::MatrixXd joint_covariance, const Values& values);

  std::vector<Key> keys;
  std::unordered_map<Key, int> place;  ///< first row of a variable
  Eigen::MatrixXd covariance;
  const Values* values;
  int size() const { return static_cast<int>(covariance.rows()); }
};

/// Whitened residual and Jacobian of a factor over all variables of a joint Gaussian.
struct LinearRows {
  Eigen::VectorXd r;
  Eigen::MatrixXd J;
};

/// Linearises a factor at the estimate; no rows for a null one. Throws Error if one of its
/// variables is not in the Gaussian.
LinearRows linear_rows(const ContinuousFactor* factor, const JointGaussian& gaussian);

}  // namespace hybrid
