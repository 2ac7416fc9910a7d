// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, the hybrid mapping authors
#pragma once

#include <map>
#include <optional>
#include <set>
#include <string>
#include <unordered_map>
#include <utility>
#include <vector>

#include "libhybrid/smoother/incremental.h"
#include "libhybrid/smoother/marginalization.h"
#include "libhybrid/smoother/past_states.h"
#include "libhybrid/smoother/proposal.h"

namespace HYBRID_API hybrid {

/// What of the past stays in the graph.
struct WindowOptions {
  enum class Mode {
    kFull,      ///< everything: full smoothing
    kFixedLag,  ///< variables that a factor touched within the last `lag` updates
    kFilter,    ///< the newest states and all else, i.e. landmarks
    kBounded    ///< what the place takes, however long the robot stays: see `sightings`
  };
  Mode mode = Mode::kFull;
  int lag = 50;  ///< in updates; 0 or less is no limit
  /// A bounded window is full smoothing until more states than this have entered.
  int complete = 3000;
  /// From then on a state leaves once this many newer ones hold each variable that it shares a
  /// factor with, i.e. have seen each landmark that it saw, and as many are newer at all. All other
  /// variables stay.
  int sightings = 50;
  /// What leaves ties no more than so many of them together by one prior, as far as a break of the
  /// chain of states costs little; two priors on nearly the same ones become one of at most twice
  /// as many.
  int tied = 40;
  /// Letters of variables that never leave, e.g. of calibrations, which all measurements share.
  std::string lasting = {};
  /// Letters of the states, which a bounded window lets go and of which a filter keeps those of the
  /// newest update that brings some, e.g. "x" for vectors in a Kalman filter; empty: all poses
  /// (SE2, SE3).
  std::string states = {};
};

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
      : window_(window), smoother_(options) {}

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
  const Estimate& past() const { return past_; }
  /// States that have left a bounded window, moved along with what they were tied to. Costs what
  /// copying them does.
  Values past_states() const;
  /// Those of them that have moved since this was asked last, when some of `changed` did.
  Values moved_past_states(const std::vector<Key>& changed) {
    return past_states_.follow(smoother_.values(), changed, past_covariances_);
  }
  /// All that was known of a discrete variable when it left, zero at its last value; null where
  /// nothing is kept.
  const Table* past_table(Key key) const;
  /// Covariance of a state when it left a bounded window; null for any other variable.
  const Eigen::MatrixXd* past_covariance(Key key) const;
  /// WindowReport::divergence of all updates so far [nat].
  double divergence() const { return divergence_; }
  /// Breaks of the chain of states so far.
  int breaks() const { return breaks_; }

 private:
  /// Variables that leave together, and what goes with them.
  struct Departure {
    std::vector<Key> keys;
    std::vector<Handle> breaks = {};    // factors that are left out
    double loss = 0.0;                  // divergence of that
    std::optional<Key> anchor = {};     // the state before the break, which stays
    std::vector<Handle> absorbed = {};  // factors that become one with what they leave behind
  };
  struct Fixed {  // discrete variables that leave at their values
    Assignment values;
    std::map<Key, Table> posterior;  // -log p of each, zero at its value
    double divergence = 0.0;
  };
  struct Change {
    Marginalization made;
    std::vector<Key> discrete;  // variables of the factors that go
    Fixed fixed;
    std::vector<std::pair<Key, Table>> settled;  // discrete variables that leave
  };

  Delta with_returning(const Delta& delta) const;
  void take_in(const Delta& delta, const Delta& change, UpdateReport& report);
  void touch(const Delta& delta, const AddedHandles& handles);
  std::vector<Key> outdated(const Delta& delta) const;
  bool is_state(Key key, VariableType type) const;
  bool leave(const Departure& going, WindowReport& report);
  bool try_to_leave(const Departure& going, WindowReport& report);
  Change change_of(const Departure& going);
  std::vector<Handle> factors_of(const Departure& going) const;
  void settle_constant(std::vector<std::pair<Key, Table>>& settled, Delta& delta);
  static void add_constant(double constant, Delta& delta);
  void take_tables(const std::vector<Handle>& tables);
  bool is_tied(Key key, const std::vector<Handle>& going) const;
  std::optional<Table> settle(Key key, Delta& delta);

  bool is_full() const { return window_.mode == WindowOptions::Mode::kFull; }

  // bounded_window.cpp
  bool is_bounded() const { return window_.mode == WindowOptions::Mode::kBounded; }
  void enter_state(Key key);
  void forget_states(const std::vector<Key>& keys);
  std::vector<Departure> surplus();
  std::vector<Departure> split(const std::vector<Key>& run) const;
  bool break_behind(Departure& going) const;
  void absorb(Key anchor, WindowReport& report);
  std::set<Key> tied_to(Key state) const;
  std::vector<Handle> priors_of(Key state) const;
  bool is_needed(Key state, std::unordered_map<Key, int>& newer) const;
  std::vector<Key> chosen_by(const std::vector<Handle>& factors,
                             const std::vector<Key>& discrete) const;
  Fixed fix(const std::vector<Key>& discrete) const;
  void hold(const Fixed& fixed, const std::vector<Handle>& breaks, Delta& delta) const;
  static std::vector<Key> tied_by(const Delta& delta);
  void note_departure(const Departure& going, const Fixed& fixed, const Eigen::MatrixXd& joint,
                      WindowReport& report);

  WindowOptions window_;
  IncrementalSmoother smoother_;
  Estimate past_;
  std::unordered_map<Key, Table> past_tables_;
  std::unordered_map<Key, int> last_touch_;               // by variable in the graph: the update
  std::unordered_map<Key, std::vector<Handle>> holders_;  // factors by discrete variable
  std::unordered_map<Key, Handle> table_;  // single-variable tables that marginalisation left
  std::optional<Handle> constant_;         // and the table over no variable
  std::set<Key> held_;                     // see hold
  int updates_ = 0;

  // Of a bounded window.
  std::vector<Key> states_;  // in the graph, in the order in which they entered
  int entered_ = 0;          // states so far
  int look_again_ = 0;       // so many have entered when it is next looked for surplus ones
  PastStates past_states_;
  std::unordered_map<Key, Eigen::MatrixXd> past_covariances_;
  double divergence_ = 0.0;
  int breaks_ = 0;
  std::set<Key> anchors_;  // states behind which the chain is broken, one for a prior
};

}  // namespace hybrid
