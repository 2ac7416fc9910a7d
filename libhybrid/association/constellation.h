// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, the hybrid mapping authors
#pragma once

#include <functional>
#include <utility>
#include <vector>

#include "libhybrid/geometry/eigen.h"

namespace HYBRID_API hybrid {

/// Landmarks about a place, in the frame of a pose there, each with its own noise: what they have
/// in common is the place of the frame.
template <class Pose>
struct Constellation {
  using Point = typename Pose::Point;
  using Matrix = Eigen::Matrix<double, Point::RowsAtCompileTime, Point::RowsAtCompileTime>;

  std::vector<Point> points;        ///< [m]
  std::vector<Matrix> covariances;  ///< of each point in the frame [m^2]
  /// Whether a point of the frame was looked at, so that a landmark there would have been seen.
  std::function<bool(const Point&)> covers;
};

/// Whether place `a` has been visited before, as `b`.
template <class Pose>
struct ConstellationMatchProblem {
  Constellation<Pose> a, b;
  Pose T_a_b;                          ///< as the map has it, ...
  typename Pose::Jacobian covariance;  ///< ... in the tangent of a right perturbation
  /// log evidence that a landmark of a (row) and one of b (column) are one by all but where they
  /// are; -infinity where they cannot be.
  Eigen::MatrixXd class_log_likelihood_ratio;
  double log_density = 0;  ///< of landmarks, per m^2 or m^3
  double missed = 0.7;     ///< -log of the probability that a landmark is not found again
};

/// Landmarks of both places that are the same, and what speaks for it.
template <class Pose>
struct ConstellationMatch {
  std::vector<std::pair<int, int>> pairs;  ///< of a and of b, ascending
  Pose T_a_b;
  double cost = 0;        ///< -log evidence against two different places: below zero speaks for one
  double chi_square = 0;  ///< of pairs and T_a_b together, 0 expected where there is no noise
};

struct PlaceOptions {
  double gate = 0.9999;   ///< chi-square probability of a pair
  int hypotheses = 2000;  ///< pairs of pairs that are followed up, at most
  int answers = 10;       ///< at most
};

/// Answers in order of their cost, no two with the same pairs. Every two pairs whose distances
/// agree place b in the frame of a; all landmarks are then matched under that, one to one, until
/// nothing changes. The evidence is that of all pairs under the prior on T_a_b (Laplace), against
/// landmarks strewn at random, with a price for those which one place shows and the other covers
/// but lacks. No answer has fewer than two pairs.
template <class Pose>
HYBRID_API std::vector<ConstellationMatch<Pose>> match_places(
    const ConstellationMatchProblem<Pose>& question, const PlaceOptions& options = {});

}  // namespace hybrid
