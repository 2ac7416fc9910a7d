// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, the hybrid mapping authors
#pragma once

#include <Eigen/Core>
#include <string>
#include <vector>

#include "libhybrid/factors/factor.h"

namespace hybrid {

/// A Gaussian on several variables, linear in their coordinates at a fixed point x0: residual
/// R e(x) + r. What marginalisation leaves behind.
///
/// The coordinates of a variable are its tangent x boxminus x0, except where it has a place in the
/// map. Measurements of the past know such variables relative to each other far better than in the
/// map, where all of them may still move together: poses by Ad(x0^-1), points by (I, -hat(x0)),
/// directions that turn with the estimate. A prior that is linear in the map therefore gains
/// information about the position and heading of everything each time the estimate moves, and a
/// window of such priors trusts itself too much. Here the first such pose is the anchor, with its
/// tangent as coordinates; other poses and points are taken in its frame, so that the rest of the
/// prior does not change when all of them move together, however far. (A robocentric prior,
/// Castellanos et al. 2007; see also Barrau and Bonnabel 2015.) In the frame of the anchor poses
/// have their tangents again, and points the coordinates of `straighten`.
class LinearPrior : public ContinuousFactor {
 public:
  /// `points` holds x0; R has one column per tangent dimension of `keys`, in their order, and is
  /// the derivative of the residual with respect to the tangents at x0. `located` says which of the
  /// variables have a place in the map (poses, and points of their dimension); empty: none.
  LinearPrior(const std::vector<Key>& keys, const Values& points, Eigen::MatrixXd R,
              Eigen::VectorXd r, std::vector<bool> located = {});

  /// From the information form: Lambda (symmetric, positive semidefinite) and gradient eta at x0,
  /// so that the cost is x' Lambda x / 2 + eta' x up to a constant.
  static ContinuousFactorPtr from_information(const std::vector<Key>& keys, const Values& points,
                                              const Eigen::MatrixXd& information,
                                              const Eigen::VectorXd& gradient,
                                              std::vector<bool> located = {});

  double cost(const double* const* x) const override;
  double linearize(const double* const* x, double* r, double* J) const override;
  double log_normalizer() const override { return 0.0; }
  std::string name() const override { return "linear prior"; }
  /// Which of the variables have a place in the map.
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
  int anchor_ = -1;              // place of the anchor among the keys; -1: there is none
  int anchor_at_ = 0;            // of its origin
  int anchor_column_ = 0;        // and of its tangent
  std::vector<double> origins_;  // x0, as seen from the anchor where in its frame
  Eigen::MatrixXd R_;            // by the coordinates
  Eigen::VectorXd r_;
};

}  // namespace hybrid
