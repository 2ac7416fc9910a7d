// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, the hybrid mapping authors
#pragma once

#include <string>
#include <vector>

#include "libhybrid/core/key.h"
#include "libhybrid/hybrid/handle.h"

namespace HYBRID_API hybrid {

/// The work of one update, or of several, and what it came to. What is counted here is counted in
/// every report, and in the records of a run.
struct UpdateWork {
  int relinearized = 0;           ///< factors linearised again, over all rounds
  int eliminated = 0;             ///< variables eliminated again, over all rounds
  int cliques = 0;                ///< cliques made, over all rounds
  int pending = 0;                ///< factors that wait to be eliminated, after it
  int flips = 0;                  ///< discrete variables whose value changed
  int components = 0;             ///< components of the discrete graph solved
  int rounds = 0;                 ///< continuous half-steps
  bool exact = true;              ///< false if a discrete component was too large and searched
  double objective_before = 0.0;  ///< eq. 6 with the new factors, at the initial values
  double objective_after = 0.0;   ///< and at the new estimate
  double seconds = 0.0;

  /// Counts a later update as well.
  void add(const UpdateWork& later) {
    relinearized += later.relinearized;
    eliminated += later.eliminated;
    cliques += later.cliques;
    pending = later.pending;
    flips += later.flips;
    components += later.components;
    rounds += later.rounds;
    exact = exact && later.exact;
    objective_after = later.objective_after;
    seconds += later.seconds;
  }
};

/// A discrete variable that a half-step gave another value.
struct Flip {
  Key key;
  int from = 0, to = 0;
  std::size_t half_step = 0;  ///< which one: index into the objectives of the report
};

/// What one update of the incremental smoother did.
struct UpdateReport : UpdateWork {
  enum class Status {
    kOk,
    kSingular,    ///< a variable would not be determined; nothing has changed
    kTurnedDown,  ///< a proposal that raises the objective too much; nothing has changed
  };

  Status status = Status::kOk;
  std::string message;    ///< what is wrong and where, if anything is
  Key under_constrained;  ///< a variable that the factors do not determine, where singular

  /// By how much linear models are off that the next update makes again, in units of the objective:
  /// large where an update ended at its limit of rounds.
  double open = 0.0;

  AddedHandles handles;            ///< of the factors that the update has added
  std::vector<double> objectives;  ///< after every half-step (eq. 10), never rising
  std::vector<Flip> flipped;       ///< the discrete variables that changed, by half-step
  /// Variables of either kind that came, or whose estimate was set anew, since the last commit.
  std::vector<Key> changed;

  /// Goes on with a later update that adds no factors: its status, and its work behind this one's.
  void go_on(const UpdateReport& later) {
    add(later);
    status = later.status;
    message = later.message;
    open = later.open;
    under_constrained = later.under_constrained;
    for (Flip flip : later.flipped) {
      flip.half_step += objectives.size();
      flipped.push_back(flip);
    }
    objectives.insert(objectives.end(), later.objectives.begin(), later.objectives.end());
    changed.insert(changed.end(), later.changed.begin(), later.changed.end());
  }
};

}  // namespace hybrid
