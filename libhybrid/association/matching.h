// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, the hybrid mapping authors
#pragma once

#include <vector>

#include "libhybrid/geometry/eigen.h"

namespace HYBRID_API hybrid {

/// Which landmark (column) each detection (row) of a frame is a sighting of: -1 for none of them.
/// No landmark is taken twice.
struct Matching {
  std::vector<int> column;
  double cost = 0.0;
};

/// Costs -log p: of detection i being a sighting of landmark j, +infinity where it cannot be; and
/// of its being something else (a new landmark or clutter), finite.
struct MatchingProblem {
  Eigen::MatrixXd matched;    ///< detections x landmarks
  Eigen::VectorXd unmatched;  ///< by detection
};

/// The matching of least cost, by shortest augmenting paths. Throws Error where the sizes differ
/// or a cost is not a number.
Matching best_matching(const MatchingProblem& problem);

/// The `k` matchings of least cost in order, by Murty's partition; fewer where there are no more,
/// or where the next costs more than `margin` above the first. Equal costs keep the order in which
/// they are found, which depends on the problem only.
std::vector<Matching> k_best_matchings(const MatchingProblem& problem, int k, double margin);

}  // namespace hybrid
