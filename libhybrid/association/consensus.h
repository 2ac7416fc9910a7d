// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, the hybrid mapping authors
#pragma once

#include <algorithm>
#include <vector>

#include "libhybrid/geometry/eigen.h"

namespace HYBRID_API hybrid {

/// The pairs of the best answer, the first, that no answer whose cost is within `margin` of it
/// contradicts. Answers have `pairs` and `cost`, and stand in the order of their costs.
template <class Answer, class Contradict>
auto undisputed(const std::vector<Answer>& answers, double margin, const Contradict& contradict) {
  auto pairs = answers.front().pairs;
  for (const Answer& other : answers) {
    if (other.cost > answers.front().cost + margin) break;
    const auto is_disputed = [&](const auto& p) {
      return std::any_of(other.pairs.begin(), other.pairs.end(),
                         [&](const auto& q) { return contradict(p, q); });
    };
    pairs.erase(std::remove_if(pairs.begin(), pairs.end(), is_disputed), pairs.end());
  }
  return pairs;
}

/// Supposed identities between two groups of landmarks: pair k says that a[k] of the one group and
/// b[k] of the other are the same thing, so that their difference, a Gaussian with the given mean
/// and joint covariance over all pairs, is in truth zero.
struct IdentityHypotheses {
  int dim = 0;  ///< of a point
  std::vector<int> a, b;
  Eigen::VectorXd difference;  ///< dim pairs
  Eigen::MatrixXd covariance;  ///< square, of the same size
  /// What a pair gains before geometry has its say: -log of the density of landmarks, which one
  /// landmark less saves, and the log evidence that their classes are the same.
  std::vector<double> gain;
};

/// Pairs that hold together.
struct ConsensusSet {
  std::vector<int> pairs;
  double cost = 0.0;        ///< -log evidence against no pair at all: below zero speaks for the set
  double chi_square = 0.0;  ///< of the differences, jointly
};

/// Sets of pairs that agree with each other under the joint covariance, least cost first. Each pair
/// starts a set; it takes in, one after the other, the pair that gains most given those it has,
/// among pairs within the gate (a probability) that contradict none of them.
std::vector<ConsensusSet> consensus_sets(const IdentityHypotheses& hypotheses, double gate);

/// The pairs of the best set that can be believed: its cost is below -margin, and no set that
/// contradicts it comes within `margin` of it; pairs in which sets that close differ are left out,
/// and so are those that only pass together with pairs that they have nothing to do with.
/// Empty where nothing can be decided yet.
ConsensusSet decided_consensus(const IdentityHypotheses& hypotheses, double gate, double margin);

}  // namespace hybrid
