// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, the hybrid mapping authors
#pragma once

#include <cstddef>
#include <vector>

#include "libhybrid/closures/problem.h"
#include "libhybrid/selection/closure_selection.h"

namespace HYBRID_API hybrid {

/// A closure that connects two parts of a trajectory, as those of two robots, which the trusted
/// factors leave apart; or one of those that tell where a part lies in the map.
struct PartLink {
  std::size_t closure = 0;     ///< its number in the problem of several parts
  std::size_t candidates = 1;  ///< closures between its two parts, or between its part and the map
  std::size_t agreeing = 1;    ///< those of them that agree with it, which counts as one
  bool to_map = false;         ///< whether it is a pose or position in the frame of the map
};

/// A problem whose parts are connected.
struct JoinedParts {
  /// That of several parts, with the links trusted, and each part where its link has it.
  RobustProblem problem;
  std::vector<std::size_t> closures;  ///< the number that each closure has in the other problem
  std::vector<PartLink> links;        ///< in the order of the last trusted factors
  std::size_t candidates = 0;         ///< closures between parts, links included
};

/// Connects the parts of a problem; what the trusted factors measure in the frame of the map is one
/// part. The first closure between two parts has nothing to contradict it, so all closures between
/// them are compared with each other before any is believed: each part is mapped alone by
/// `select_closures`, and one closure predicts all others through the maps of the two parts. Two
/// parts are joined by the closure for which the others give the most evidence, those first that
/// have most of it. Only where no set of closures agrees, it is the first one in order. The
/// comparisons are those of up to 100,000 pairs, or of 8 closures with all others.
///
/// A closure of one variable is a pose or a position in the frame of the map, which may be false,
/// too. A part that no trusted factor holds lies where as few of them as hold it (one pose, two
/// positions in the plane, three in space) agree with most others; these are its links.
JoinedParts join_parts(const RobustProblem& problem, const ClosureSelectionOptions& options = {});

/// The decisions on the links, given all others, from the result of a solver for the joined
/// problem. A link is trusted, not accepted, where no other closure supports it.
std::vector<ClosureDecision> judge_links(const JoinedParts& joined, const RobustResult& result,
                                         const ClosureSelectionOptions& options = {});

}  // namespace hybrid
