// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, the hybrid mapping authors

#pragma once

#include <cstddef>
#include <cstdint>
#include <limits>
#include <optional>
#include <utility>
#include <vector>

#include "libhybrid/landmarks/association_decision.h"
#include "mrpt_plugins/mapping/map_result.h"

namespace HYBRID_API hybrid {

/// Pairs of an estimated and a true landmark, as indices into the two lists.
using LandmarkMatching = std::vector<std::pair<std::size_t, std::size_t>>;

/// Matches equal ids; a second estimate with the same id stays unmatched.
LandmarkMatching match_by_id(const std::vector<LandmarkEstimate>& estimates,
                             const std::vector<TrueLandmark>& truth);

/// Matches one to one, nearest pairs first, at most `radius` metres apart.
LandmarkMatching match_by_distance(const std::vector<LandmarkEstimate>& estimates,
                                   const std::vector<TrueLandmark>& truth, double radius);

/// Ids of true landmarks that fit far better if exchanged, in pairs, where all others fit: two rows
/// of a file of truth that were mixed up.
std::vector<std::pair<std::int64_t, std::int64_t>> exchanged_ids(
    const LandmarkMatching& matching, const std::vector<LandmarkEstimate>& estimates,
    const std::vector<TrueLandmark>& truth);

/// Errors of the matched landmarks, and how many estimated (spurious) and true (missed) ones are
/// unmatched.
struct LandmarkErrors {
  std::size_t matched = 0, spurious = 0, missed = 0;
  double mean_m = 0, max_m = 0;  ///< NaN when nothing is matched
  /// Fractions of the estimated and of the true landmarks that are matched; NaN if there are none.
  double precision() const { return share(matched, matched + spurious); }
  double recall() const { return share(matched, matched + missed); }

 private:
  static double share(std::size_t part, std::size_t all) {
    return all == 0 ? std::numeric_limits<double>::quiet_NaN()
                    : static_cast<double>(part) / static_cast<double>(all);
  }
};

LandmarkErrors landmark_errors(const LandmarkMatching& matching,
                               const std::vector<LandmarkEstimate>& estimates,
                               const std::vector<TrueLandmark>& truth);

/// Fraction of the matched landmarks with a true class whose estimated class is right; empty when
/// the truth or the map has no classes.
std::optional<double> class_accuracy(const LandmarkMatching& matching,
                                     const std::vector<LandmarkEstimate>& estimates,
                                     const std::vector<TrueLandmark>& truth);

/// Normalised estimation error squared: mean of e' P^-1 e per coordinate over the matched landmarks
/// with a covariance; 1 if the covariances are consistent. Empty without such landmarks.
std::optional<double> landmark_nees(const LandmarkMatching& matching,
                                    const std::vector<LandmarkEstimate>& estimates,
                                    const std::vector<TrueLandmark>& truth);

/// How many measurements were attributed correctly.
struct AssociationReport {
  std::size_t labelled = 0;    ///< measurements with a true id
  std::size_t right = 0;       ///< of them, attributed to the landmark paired with the true id
  std::size_t rejected = 0;    ///< of them, rejected as clutter
  std::size_t unlabelled = 0;  ///< measurements without a true id
  std::size_t unlabelled_rejected = 0;  ///< of them, rejected as clutter
  double accuracy() const { return static_cast<double>(right) / static_cast<double>(labelled); }
};

/// Pairs landmarks of the map with true ids one to one, those with the most measurements in common
/// first. Measurements attributed to a duplicate of a landmark therefore count as wrong.
AssociationReport association_report(const std::vector<AssociationDecision>& decisions);

}  // namespace hybrid
