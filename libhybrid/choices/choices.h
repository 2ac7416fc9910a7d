// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, the hybrid mapping authors
#pragma once

#include <cstddef>
#include <optional>
#include <utility>
#include <vector>

#include "libhybrid/choices/open_choices.h"
#include "libhybrid/selection/closure_selection.h"
#include "libhybrid/smoother/incremental.h"

namespace HYBRID_API hybrid {

struct ChoiceOptions {
  /// Joint values of open choices of less evidence than the best by this much (log) are dropped.
  /// Other values of the choices of largest cost are tried when an update raises the cost of the
  /// graph by more than this beyond its expected rise by noise.
  double decisive = 10.0;
  /// Number of closures kept back by a group of choices at which its best joint value is taken,
  /// however close the next one is.
  std::size_t patience = 40;
  ClosureSelectionOptions selection;  ///< of closures under each joint value
};

/// Closures that may be false, and whether each is accepted at present.
struct JudgedClosures {
  std::vector<ContinuousFactorPtr> factors;
  std::vector<bool> accepted;
};

/// Whether every new pose has a factor with the one before it, and all other factors but closures
/// involve a new variable. If not, open choices may not be the only connection of the poses on both
/// sides.
bool is_chained(const Delta& delta);

/// Decides about measurements with several hypotheses (choices) of a map that grows.
///
/// A wrong choice about a step of odometry costs nothing until the robot returns to a known place;
/// then its error spreads over the whole loop, so that no other value of a single choice costs
/// less: the alternation of eq. 8 is stuck. Closures that span open choices are therefore kept back
/// until they tell the joint values of these choices apart by their evidence (ChoiceComparison), in
/// which those that may be false take part as such; then they enter together with the remaining
/// joint value. One that no joint value explains is false and keeps no choice open. If the cost of
/// the map rises nevertheless, the choices of largest cost are fixed to their other values, one by
/// one, and keep a value that lowers the joint objective. So every choice can be revised.
///
/// It holds no map: each function is given the smoother, and those that change it need a
/// transaction of the caller, and throw Refused where the smoother refuses an update.
class Choices {
 public:
  explicit Choices(const ChoiceOptions& options) : options_(options) {}

  /// What a change may alter, to go back to by `restore`.
  struct State {
    std::size_t count = 0;
    OpenChoices open;
    double explained = 0.0, settled = 0.0;
    int trials = 0;
  };
  State save() const { return {choices_.size(), open_, explained_, settled_, trials_}; }
  void restore(State&& before);

  bool empty() const { return choices_.empty(); }
  int trials() const { return trials_; }  ///< other values tried so far
  /// Number of closures kept back.
  std::size_t waiting() const { return open_.waiting(); }
  /// Whether a choice between two poses is open.
  bool are_open_between(Key a, Key b) const { return !open_.between(a, b).empty(); }

  /// Removes the closures that span open choices from a change, and returns them.
  std::vector<ContinuousFactorPtr> keep_back(Delta& delta, const Values& present) const;
  /// Takes note of the choices of a change that the smoother has applied. Those between a pose and
  /// the next are open.
  void note(const Delta& applied);
  /// Takes note of factors that enter, for the rise in cost that noise explains.
  void expect(const std::vector<ContinuousFactorPtr>& entering);
  /// Keeps a closure over open choices back; returns whether. One that may be false is not where no
  /// joint value of these choices explains it.
  bool keep(const WaitingClosure& closure, const IncrementalSmoother& smoother);

  /// Compares the values of a group that closures have joined, and gives its choices the best.
  /// Returns the closures that wait no longer; none if no group is left to compare.
  std::optional<std::vector<WaitingClosure>> decide_next(IncrementalSmoother& smoother);
  /// No choice is open any longer; returns all closures that waited.
  std::vector<WaitingClosure> close_all() { return open_.close_all(); }

  /// Choices that more closures contradict than support. A wrong choice keeps closures out that
  /// span it; two that come one after the other and whose errors nearly cancel, those that span one
  /// of the two. Those first of which the smallest share is in.
  std::vector<std::vector<std::size_t>> doubted(const JudgedClosures& closures) const;
  /// The joint values of choices, the best first, by the newest closures that they keep out and the
  /// newest that are in.
  ChoiceGroup compare_again(const std::vector<std::size_t>& choices, const JudgedClosures& closures,
                            const IncrementalSmoother& smoother) const;
  /// Whether the best joint value of a group is not the present one.
  bool differs(const ChoiceGroup& group, const IncrementalSmoother& smoother) const {
    return !changed(group, smoother).empty();
  }
  /// The estimate if a group had its best joint value, with the poses behind its choices moved.
  /// Counts as a trial.
  Estimate with(const ChoiceGroup& group, const IncrementalSmoother& smoother);
  /// Gives the choices of a group their best joint value, and moves the poses behind them.
  void take(const ChoiceGroup& group, IncrementalSmoother& smoother) const;

  /// Tries other values of choices where the cost has risen more than noise explains.
  void revise(IncrementalSmoother& smoother);
  /// Tries other values of the choices of largest cost; returns whether one was better.
  bool resolve(IncrementalSmoother& smoother);

 private:
  int value_of(std::size_t choice, const IncrementalSmoother& smoother) const;
  ChoiceGroup& join(const std::vector<std::size_t>& choices, const IncrementalSmoother& smoother,
                    OpenChoices& among) const;
  bool in_the_plane(const ChoiceGroup& group) const;
  bool is_explained(const ContinuousFactorPtr& closure, const std::vector<std::size_t>& choices,
                    const IncrementalSmoother& smoother) const;
  template <class Pose>
  bool is_explained_by(const ChoiceGroup& group, const IncrementalSmoother& smoother) const;
  void compare(ChoiceGroup& group, const IncrementalSmoother& smoother) const;
  template <class Pose>
  void compare_as(ChoiceGroup& group, const IncrementalSmoother& smoother) const;
  int spanned(const ContinuousFactor& closure, const std::vector<std::size_t>& choices) const;
  std::vector<std::size_t> strained(const IncrementalSmoother& smoother) const;
  std::vector<std::pair<std::size_t, int>> changed(const ChoiceGroup& group,
                                                   const IncrementalSmoother& smoother) const;
  template <class Pose>
  void take_as(const std::vector<std::pair<std::size_t, int>>& chosen,
               IncrementalSmoother& smoother) const;
  bool try_value(std::size_t choice, int value, IncrementalSmoother& smoother);

  ChoiceOptions options_;
  std::vector<Choice> choices_;
  OpenChoices open_;        // that alone connect the poses on both sides
  double explained_ = 0.0;  // expected cost, by noise, of factors added since the last update
  double settled_ = 0.0;    // continuous cost after the last update
  int trials_ = 0;
};

}  // namespace hybrid
