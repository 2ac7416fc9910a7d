// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, the hybrid mapping authors
#pragma once

#include <vector>

#include "libhybrid/uncertainty/detail/sighting_pairs.h"
#include "libhybrid/uncertainty/sensor_delay.h"

namespace hybrid {

/// The frames that saw something, without `at_rest` those that the robot was moving at; as many as
/// the budget of comparisons allows, from all parts of the log. In space if all detections are.
PolarLog polar_log(const std::vector<MovedSightings>& frames, bool at_rest);

/// The rows of a pair, one for each coordinate: of the two models of the noise, that by what is
/// stated or that by the range.
void add_rows(const PolarLog& log, const SightingPair& pair, bool by_stated,
              std::vector<VarianceRow>& out);
std::vector<VarianceRow> rows_of(const PolarLog& log, const std::vector<SightingPair>& pairs,
                                 bool by_stated);

/// Right pairs told from wrong ones, by the variances of right ones.
struct PairMixture {
  std::vector<SightingPair> pairs;
  Components variances = Components::Zero();
  double share = 0.5;  ///< of pairs that are right
};
PairMixture fit_mixture(const PolarLog& log);

/// Joins likely pairs into tracks.
void follow(const std::vector<SightingPair>& pairs, PolarLog& log);

/// Pairs of sightings of one track so many frames apart.
std::vector<SightingPair> pairs_at(const PolarLog& log, std::size_t lag);

}  // namespace hybrid
