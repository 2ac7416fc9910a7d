// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, the hybrid mapping authors

#pragma once

#include <optional>
#include <utility>
#include <vector>

#include "mrpt_plugins/output/result.h"

namespace hybrid {

/// Which estimated landmark is which true one, as indices into the two lists.
using LandmarkMatching = std::vector<std::pair<std::size_t, std::size_t>>;

/// Matches equal ids; a second estimate with the same id stays unmatched.
LandmarkMatching match_by_id(const std::vector<LandmarkEstimate>& estimates,
                             const std::vector<TrueLandmark>& truth);

/// Matches one to one, nearest pairs first, at most `radius` metres apart.
LandmarkMatching match_by_distance(const std::vector<LandmarkEstimate>& estimates,
                                   const std::vector<TrueLandmark>& truth, double radius);

/// Errors of the matched landmarks, and how many estimates and truths have no partner.
struct LandmarkErrors {
  std::size_t matched = 0, spurious = 0, missed = 0;
  double mean_m = 0, max_m = 0;  ///< NaN when nothing is matched
};

LandmarkErrors landmark_errors(const LandmarkMatching& matching,
                               const std::vector<LandmarkEstimate>& estimates,
                               const std::vector<TrueLandmark>& truth);

/// Fraction of the matched landmarks with a true class whose estimated class is right; empty when
/// the truth has no classes.
std::optional<double> class_accuracy(const LandmarkMatching& matching,
                                     const std::vector<LandmarkEstimate>& estimates,
                                     const std::vector<TrueLandmark>& truth);

/// What one measurement was attributed to and what it really came from; empty means clutter.
struct AssociationDecision {
  std::optional<std::int64_t> estimated_id;
  std::optional<std::int64_t> true_id;
};

/// Fraction of the decisions that are right: clutter called clutter, or the estimated landmark
/// matched to the true one. Empty when there are no decisions.
std::optional<double> association_accuracy(const std::vector<AssociationDecision>& decisions,
                                           const LandmarkMatching& matching,
                                           const std::vector<LandmarkEstimate>& estimates,
                                           const std::vector<TrueLandmark>& truth);

}  // namespace hybrid
