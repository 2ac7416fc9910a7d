// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, the hybrid mapping authors
#pragma once

#include <cstddef>
#include <deque>
#include <map>
#include <unordered_map>
#include <utility>
#include <vector>

#include "libhybrid/core/values.h"
#include "libhybrid/geometry/eigen.h"
#include "libhybrid/smoother/marginalization.h"

namespace HYBRID_API hybrid {

/// States that have left a window, each with what it was tied to then: when a loop closes, what is
/// left of the place moves, and the states that left move along. Costs the places of what they were
/// tied to, once for all that leave together.
class PastStates {
 public:
  /// States that leave together, and the poses and points that they are tied to, where they are.
  struct Departure {
    Values states, tied;
    /// Of each pose, what its own tangent moves by where all that it is tied to moves by a rigid
    /// motion of that tangent: the unit matrix, unless more is known of where it is.
    std::unordered_map<Key, Eigen::MatrixXd> follows;
    /// By how much what they are tied to moves before they follow [m]: half the sigma of the
    /// position of a state, all else given.
    double step = 0;
    bool waits = false;  ///< for its turn to follow

    Departure() = default;
    /// `tied` are those of the separator that have a place.
    Departure(const Marginalization& made, const std::vector<Key>& tied, const Values& values);
  };

  void leave(Departure departure);

  /// The states at the estimate of the window. Each is moved rigidly, as what it was tied to has
  /// moved in the least squares sense, as far as it then follows that (a start that was given
  /// stays) and its covariance allows beside what that motion leaves unexplained. Those that are in
  /// the window again are left out. `covariances` are those of the states when they left.
  Values at(const Values& window,
            const std::unordered_map<Key, Eigen::MatrixXd>& covariances) const;

  /// The states that have moved since they were told last, or left, so that what is told is whole
  /// at every moment: some of `changed` have moved. A departure follows a variable once that has
  /// moved by Departure::step, rounded down to a power of two. Where more are due than have
  /// changed, they take turns, so that following costs no more than the update that it follows.
  Values follow(const Values& window, const std::vector<Key>& changed,
                const std::unordered_map<Key, Eigen::MatrixXd>& covariances);

 private:
  /// What hangs on a variable and follows from about the same step on.
  struct Followers {
    std::vector<std::size_t> departures;
    Values followed;  ///< where the variable was when they did last
  };
  /// By the binary logarithm of the step, rounded down: a start that is held to a micrometre does
  /// not make all that saw the same landmark follow each micrometre.
  using Tie = std::map<int, Followers>;

  void ask(Key key, const Values& now);
  /// The states of a departure where their ties are now, in the window or else among `past`.
  static void move(const Departure& departure, const Values& window, const Values& past,
                   const std::unordered_map<Key, Eigen::MatrixXd>& covariances, Values& out);

  std::vector<Departure> departures_;
  std::unordered_map<Key, Tie> ties_;
  std::deque<std::size_t> waiting_;                    // departures that are due, in their turn
  Values told_;                                        // of all states
  std::unordered_map<Key, std::size_t> departure_of_;  // the last one of each state
};

}  // namespace hybrid
