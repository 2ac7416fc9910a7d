// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, the hybrid mapping authors
#pragma once

#include <Eigen/Core>
#include <vector>

#include "libhybrid/closures/problem.h"
#include "libhybrid/core/values.h"
#include "libhybrid/factors/factor.h"
#include "libhybrid/selection/selection_options.h"

namespace HYBRID_API hybrid {

/// The evidence for a closure: the density of its innovation, marginalised over the poses (p(d | Z)
/// with the Laplace approximation of eq. 11b), relative to that of a false closure. That may
/// measure any relative pose inside the map; one by a MistakablePlace may also measure another
/// place that looks the same, and the likelier of the two counts.
struct EvidenceModel {
  /// Innovations of true closures follow a Student t of these degrees of freedom and of the
  /// predicted covariance times `variance_factor`: noise models are inaccurate, and real noise has
  /// heavy tails.
  double degrees = 4.0;
  /// The factor by which the variances of the noise are understated (above one) or overstated.
  double variance_factor = 1.0;
  /// The log evidence is -infinity if the chi-square of the innovation, by its predicted
  /// covariance, exceeds this multiple of the 0.9999 quantile, however many closures agree with
  /// each other.
  double gate = 4.0;
  /// Radius of the map [m].
  double radius = 1.0;

  /// The chi-square of `degrees` degrees of freedom beyond which the log evidence is -infinity.
  double limit(int degrees) const;

  /// log of the ratio of the two densities for a whitened innovation b (d entries) of covariance S
  /// (d x d) of a factor.
  double log_ratio(const Eigen::VectorXd& b, const Eigen::MatrixXd& S,
                   const ContinuousFactor& factor) const;
  /// An upper bound of log_ratio over all covariances between the identity, which is the noise of
  /// the closure itself, and S.
  double largest_log_ratio(const Eigen::VectorXd& b, const Eigen::MatrixXd& S,
                           const ContinuousFactor& factor) const;
  /// The same relative to any pose inside the map, of an innovation of that chi-square by its
  /// predicted covariance, of that log determinant: at least log_ratio.
  double density_ratio(double chi_square, double log_det, const ContinuousFactor& factor) const;

 private:
  double log_density(double chi_square, double log_det, int dimensions) const;
};

/// The log evidence for a closure relative to that of a false one or of an alternative to it, which
/// have these prior odds to a false one.
double against_alternatives(std::size_t closure, const std::vector<double>& evidence,
                            const Alternatives& alternatives, double log_odds = 0.0);

/// Sets redundancy, checkability, probability, evidence and margin of decisions from the log
/// evidence for each closure and its redundancy, given all others but its alternatives, to which it
/// is compared, too; whether each is accepted is set.
void write_evidence(const std::vector<double>& alone, const std::vector<double>& redundancy,
                    const Alternatives& alternatives, const ClosureSelectionOptions& options,
                    std::vector<ClosureDecision>& decisions);

/// The log evidence that a closure needs if so many are not admitted.
double evidence_needed(std::size_t not_admitted, const ClosureSelectionOptions& options);

/// log of the volume of what a false closure measures that is of no place: positions in a map of
/// that radius [m] and any rotation.
double log_volume(const ContinuousFactor& factor, double radius);

/// The 0.9999 quantile of a chi-square.
double gate_quantile(int degrees);

/// Twice the root mean square distance of the variables from their centre [m].
double map_radius(const Values& values);

/// Robust estimate of the variance factor from chi-squares and degrees of freedom: the quantile of
/// that probability of their ratios to the same quantile of a chi-square (0.5: the medians), shrunk
/// towards one by a prior.
double variance_factor(const std::vector<double>& chi_squares, const std::vector<int>& degrees,
                       double probability = 0.5);

}  // namespace hybrid
