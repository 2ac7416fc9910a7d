// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, the hybrid mapping authors
#pragma once

#include <cstddef>
#include <vector>

#include "libhybrid/closures/problem.h"

namespace HYBRID_API hybrid {

/// Whether closures that were measured far apart in time agree in space: with the path, or with
/// each other and against it. They are counted by passages, each of which is what was measured
/// while the robot went once through two stretches of its path: a place that is mistaken for
/// another gives many closures in one passage, and they agree.
struct ClosureAgreement {
  std::size_t agreeing = 0;  ///< passages that the rest of the map predicts
  /// Passages that the map contradicts, while others agree with them: more than chance would give.
  std::size_t rivals = 0;
  std::size_t alone = 0;  ///< passages that the map contradicts, and nothing else supports
  double ratio = 0;       ///< agreeing / (agreeing + rivals), NaN where there are none of both

  /// The same of the passages that begin or end in one stretch of the path.
  struct Stretch {
    std::size_t first = 0;  ///< how many poses are before it, in the order of their keys
    double ratio = 0;
    std::size_t passages = 0;
  };
  std::vector<Stretch> stretches;  ///< in order; those with passages alone
  std::vector<std::size_t>
      rival_closures;  ///< closures, one of each rival passage, the most supported first
};

/// The agreement of the closures of a problem with an estimate that rests on what is trusted and on
/// those that were accepted. Each passage is judged by its middle closure, held out from the map.
/// Two of those that the map contradicts agree if the circle through both, along the map between
/// their ends, closes within their covariances. Residuals may be `scale` times what the information
/// says. It takes at most 200 passages, evenly spread. Throws Error where values are missing, or
/// `accepted` is not one for each closure.
ClosureAgreement agreement_of_closures(const RobustProblem& problem, const Values& values,
                                       const std::vector<bool>& accepted, double scale = 1);

}  // namespace hybrid
