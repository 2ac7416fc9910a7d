// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, the hybrid mapping authors
#pragma once

#include <set>
#include <string>
#include <unordered_map>
#include <vector>

#include "libhybrid/smoother/incremental.h"
#include "libhybrid/smoother/proposal.h"
#include "libhybrid/smoother/state_chain.h"
#include "libhybrid/smoother/window_past.h"
#include "libhybrid/smoother/window_tables.h"

namespace HYBRID_API hybrid {

/// What an update of a window did besides the update proper. `objectives` are those of the update
/// proper, `objective_after` is that of the window after what was to leave has left.
struct WindowReport : UpdateReport {
  int marginalized = 0;            ///< continuous variables that left the graph
  int fill = 0;                    ///< pairs of variables newly tied together by that
  std::vector<Key> left;           ///< the continuous variables that left
  std::vector<Key> left_discrete;  ///< and the discrete ones
  /// Of those that left, the ones of which their factors left a direction open at the estimate (a
  /// robust loss that rejects all of them, a range of zero): nothing was known of it.
  std::vector<Key> undetermined;
  /// Those that were to leave and have not, as the rest would not be determined without them or one
  /// of their factors threw, and why. They are to leave at every later update, with what depends on
  /// them in the end.
  std::vector<Key> kept;
  std::string kept_because;
  /// Of a bounded window: what the remaining density has lost by this update, in Kullback-Leibler
  /// divergence [nat], beside what linearisation costs: -log p of the values at which discrete
  /// variables were fixed, and, as a bound, the breaks of the chain of states.
  double divergence = 0.0;
  int breaks = 0;
};

/// The incremental smoother over a window: old states are marginalised by the Schur complement into
/// priors on what remains, and discrete variables leave with the last continuous variable they say
/// something about. Variables that have left keep their last estimate, for trajectories and maps.
///
/// The objective of the smoother is -log of the joint density of eq. 6 with the continuous
/// variables that have left integrated out (by Laplace, exactly where the problem is linear) and
/// the discrete ones at their last values. So it is comparable across departures: a departure adds
/// log det(Lambda / 2 pi) / 2, with Lambda the information about what leaves given the rest. What
/// the priors do not say of it is in a table over no variable. The cost is that of the factors
/// and priors in the window alone.
///
/// A variable that has left and that a new factor holds enters again: a continuous one as a new
/// variable, initialised at its last estimate, with nothing known of it but what the new factors
/// say (the window's priors keep what it once said about the others, so nothing counts twice); a
/// discrete one with all that was known of it.
class WindowSmoother {
 public:
  explicit WindowSmoother(const WindowOptions& window = {}, const SmootherOptions& options = {})
      : window_(window), smoother_(options), chain_(window) {}

  WindowReport update(const Delta& delta);
  /// A change on trial, see propose(IncrementalSmoother&, ...). Nothing leaves before the next
  /// update, so that the objectives before and after tell what the change is worth.
  WindowReport propose(const Proposal& proposal);
  UpdateReport converge(int max_rounds = 50, double tolerance = 1e-10) {
    return smoother_.converge(max_rounds, tolerance);
  }

  UpdateReport settle() { return smoother_.settle(); }

  /// Keeps a variable in the graph, e.g. one of which something is to be taken back, until
  /// `release`.
  void hold(Key key) { held_.insert(key); }
  void release(Key key) { held_.erase(key); }

  /// Converges from another place, of all variables in the window, and stays there only if the
  /// objective is lower then; the report is empty if it is not.
  UpdateReport converge_from(const Values& start);

  UpdateReport keep_last(const std::vector<Key>& keys) { return smoother_.keep_last(keys); }

  const IncrementalSmoother& smoother() const { return smoother_; }
  /// Last estimates of the variables that have left, and last values of discrete ones.
  const Estimate& past() const { return past_.estimate(); }
  /// States that have left a bounded window, moved along with what they were tied to. Costs what
  /// copying them does.
  Values past_states() const { return past_.states(smoother_.values()); }
  /// Those of them that have moved since this was asked last, when some of `changed` did.
  Values moved_past_states(const std::vector<Key>& changed) {
    return past_.moved_states(smoother_.values(), changed);
  }
  /// All that was known of a discrete variable when it left, zero at its last value; null where
  /// nothing is kept.
  const Table* past_table(Key key) const { return past_.table(key); }
  /// Covariance of a state when it left a bounded window; null for any other variable.
  const Eigen::MatrixXd* past_covariance(Key key) const { return past_.covariance(key); }
  /// WindowReport::divergence of all updates so far [nat].
  double divergence() const { return divergence_; }
  /// Breaks of the chain of states so far.
  int breaks() const { return breaks_; }

 private:
  struct Change;

  void take_in(const Delta& delta, const Delta& change, UpdateReport& report);
  void touch(const Delta& delta, const AddedHandles& handles);
  std::vector<Key> outdated(const Delta& delta) const;
  bool leave(const Departure& going, WindowReport& report);
  bool try_to_leave(const Departure& going, WindowReport& report);
  Change change_of(const Departure& going);
  std::vector<Handle> factors_of(const Departure& going) const;
  void note_departure(const Departure& gone, double fixed, WindowReport& report);

  bool is_full() const { return window_.mode == WindowOptions::Mode::kFull; }
  bool is_bounded() const { return window_.mode == WindowOptions::Mode::kBounded; }

  WindowOptions window_;
  IncrementalSmoother smoother_;
  WindowPast past_;
  WindowTables tables_;
  StateChain chain_;                         // of a bounded window
  std::unordered_map<Key, int> last_touch_;  // by variable in the graph: the update
  std::set<Key> held_;                       // see hold
  int updates_ = 0;
  double divergence_ = 0.0;
  int breaks_ = 0;
};

}  // namespace hybrid
