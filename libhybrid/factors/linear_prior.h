// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, the hybrid mapping authors
#pragma once

#include <Eigen/Core>
#include <string>
#include <vector>

#include "libhybrid/factors/factor.h"

namespace HYBRID_API hybrid {

/// A Gaussian on several variables, linear in their coordinates e(x) about a fixed point x0:
/// residual R e(x) + r. It is the factor that marginalisation leaves.
///
/// The coordinates of a variable are its tangent x boxminus x0, unless it is located in the map (a
/// pose or a landmark). Past measurements determine located variables relative to each other far
/// better than in the map, where all of them may still move together: poses by Ad(x0^-1), points by
/// (I, -hat(x0)), directions that change with the estimate. A prior that is linear in map
/// coordinates therefore gains information about the common position and heading each time the
/// estimate moves, and a window of such priors becomes overconfident. Here the first located pose
/// is the anchor, with its tangent as coordinates; the other located poses and points are expressed
/// in its frame, so that the rest of the prior does not change when all of them move together,
/// however far. (A robocentric prior, Castellanos et al. 2007; see also Barrau and Bonnabel 2015.)
/// The coordinates of poses in the frame of the anchor are their tangents again, those of points
/// are given by `straighten`.
class LinearPrior : public ContinuousFactor {
 public:
  /// `points` holds x0; R has one column per tangent dimension of `keys`, in their order, and is
  /// the derivative of the residual with respect to the tangents at x0. `located` marks the
  /// variables that are located in the map (poses, and points of their dimension); empty: none.
  /// Throws Error if R and r do not fit the variables.
  LinearPrior(const std::vector<Key>& keys, const Values& points, Eigen::MatrixXd R,
              Eigen::VectorXd r, std::vector<bool> located = {});

  /// From the information form: Lambda (symmetric, positive semidefinite) and gradient eta at x0,
  /// so that the cost is x' Lambda x / 2 + eta' x up to a constant. Directions whose information is
  /// rounding error are left out. Where Lambda was got by subtraction, `computed_from` is the
  /// diagonal before, which tells how large these errors are.
  static ContinuousFactorPtr from_information(const std::vector<Key>& keys, const Values& points,
                                              const Eigen::MatrixXd& information,
                                              const Eigen::VectorXd& gradient,
                                              std::vector<bool> located = {},
                                              const Eigen::VectorXd& computed_from = {});

  double cost(const double* const* x) const override;
  double linearize(const double* const* x, double* r, double* J) const override;
  double log_normalizer() const override { return 0.0; }
  std::string name() const override { return "linear prior"; }
  /// Which of the variables are located in the map.
  const std::vector<bool>& located() const { return located_; }
  using ContinuousFactor::cost;

 private:
  template <class Pose>
  void express();
  template <class Pose>
  Eigen::VectorXd coordinates(const double* const* x, double* J) const;
  Eigen::VectorXd coordinates(const double* const* x, double* J) const;

  std::vector<bool> located_;
  std::vector<bool> in_frame_;   // which variables are expressed in the frame of the anchor
  int anchor_ = -1;              // index of the anchor among the keys; -1: there is none
  int anchor_at_ = 0;            // offset of the anchor in origins_
  int anchor_column_ = 0;        // first column of the anchor in R_
  std::vector<double> origins_;  // x0; in the frame of the anchor where in_frame_
  Eigen::MatrixXd R_;            // derivative of the residual with respect to the coordinates
  Eigen::VectorXd r_;
};

}  // namespace hybrid
