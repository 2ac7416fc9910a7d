// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, the hybrid mapping authors
#pragma once

#include <memory>
#include <vector>

#include "libhybrid/selection/detail/candidate.h"
#include "libhybrid/selection/evidence.h"

namespace hybrid {

/// Closures near those that a batch admits, told by short paths instead of by a new map: the motion
/// between the two ends of a closure is composed of trusted measurements and of closures that are
/// in. A path has no more information than the map, so it predicts the closure less precisely; but
/// it needs no solution, and its motions are composed exactly, however far the map has drifted.
class ClosureFront {
 public:
  virtual ~ClosureFront() = default;

  /// What is known before the batch.
  struct Known {
    const Values& values;               ///< of the map given the admitted closures
    const std::vector<bool>& admitted;  ///< by closure
    const std::vector<bool>& open;      ///< those that may be added
    const EvidenceModel& model;
    double needed = 0.0;  ///< log evidence for an addition
  };
  /// The closures that reach the needed evidence by a path through the batch or through others of
  /// the result, in the order in which they were found.
  virtual std::vector<Candidate> beyond(const std::vector<Candidate>& batch,
                                        const Known& known) = 0;

  /// The values with each pose chained along the tree of shortest paths of trusted measurements and
  /// admitted closures, where the length is the variance of the rotation. Poses of roots and all
  /// other variables stay.
  virtual Values chained(const Values& values, const std::vector<bool>& admitted) const = 0;
};

/// Null if no closure measures a relative pose.
std::unique_ptr<ClosureFront> make_closure_front(const RobustProblem& problem);

}  // namespace hybrid
