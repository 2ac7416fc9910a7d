// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, the hybrid mapping authors
#pragma once

#include <Eigen/Core>
#include <memory>
#include <utility>
#include <vector>

#include "libhybrid/factors/bearing_range.h"
#include "libhybrid/hybrid/weighted.h"

namespace HYBRID_API hybrid {

/// phi(s) of eq. 19 as a table: -log of the likelihood p(what the detector said | true class s) for
/// each class. Not normalised over s, since it is a likelihood; zero makes a class impossible.
/// Throws Error unless there is one finite, non-negative likelihood per class and one is positive.
Table likelihood_table(DiscreteKey class_key, const std::vector<double>& likelihood);

/// The likelihood of each true class when the detector reports class `detected`: a column of its
/// confusion matrix C(s, d) = p(reports d | true class s), whose rows must sum to one within 1e-6.
std::vector<double> likelihood_of_detection(const Eigen::MatrixXd& confusion, int detected);

/// The likelihood of each true class, up to a common factor, when the detector gives a score vector
/// that is a posterior p(s | image): score(s) / prior(s), where `prior` holds the class frequencies
/// of its training, uniform if empty. A class has at least the likelihood of `floor` (a score), so
/// that no single detection can rule a class out.
std::vector<double> likelihood_of_scores(const std::vector<double>& scores,
                                         const std::vector<double>& prior = {},
                                         double floor = 1e-6);

/// The semantic range-bearing measurement of a landmark l = (p, s), eq. 19:
/// f(x, l) = phi(s) psi(x, p), with phi the likelihoods of the classes and psi a BearingRange.
template <class Pose>
HybridFactorPtr make_semantic_bearing_range(Key pose, Key point, DiscreteKey class_key,
                                            const typename Pose::Point& measured,
                                            const Noise& noise,
                                            const std::vector<double>& likelihood,
                                            const Pose& T_robot_sensor = {}, Loss loss = {}) {
  return std::make_shared<WeightedFactor>(
      std::make_shared<BearingRange<Pose>>(pose, point, measured, noise, T_robot_sensor, loss),
      likelihood_table(class_key, likelihood));
}

}  // namespace hybrid
