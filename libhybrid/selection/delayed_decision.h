// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, the hybrid mapping authors
#pragma once

#include <cstddef>
#include <vector>

#include "libhybrid/selection/attempts.h"
#include "libhybrid/smoother/incremental.h"

namespace HYBRID_API hybrid {

struct DelayedDecisionOptions {
  DelayedDecisionOptions() {
    smoother.relinearize = 3e-2;
    smoother.wildfire = 1e-3;
  }
  /// Joint values of open choices that cost more than the best by this much (in -log likelihood)
  /// are dropped.
  double margin = 15.0;
  /// Number of closures kept back by a group of choices at which its best joint value is taken,
  /// however close the next one is.
  std::size_t patience = 40;
  /// Other values of the choices of largest cost are tried when an update raises the cost of the
  /// graph by more than this beyond its expected rise by noise.
  double surprise = 10.0;
  SmootherOptions smoother;
};

/// Delayed decision about measurements with several hypotheses (choices), online. A wrong choice
/// costs nothing until the robot returns to a known place; then its error spreads over the whole
/// loop, so that no other value of a single choice costs less: the alternation of eq. 8 is stuck.
/// Closures that span open choices are therefore kept back until they tell the joint values of
/// these choices apart (ChoiceComparison); then they enter the smoother together with the remaining
/// joint value. Choices that no common closure spans are decided independently, so that the number
/// of joint values stays small. If the cost of the map rises nevertheless, the choices of largest
/// cost are fixed to their other values, one by one, and keep a value that lowers the joint
/// objective of eq. 6. So every choice can be revised.
///
/// Every change is all or nothing, as those of IncrementalSmoother: if it throws, or its report
/// says that the system is singular, nothing has changed.
class DelayedDecisionSmoother {
 public:
  explicit DelayedDecisionSmoother(const DelayedDecisionOptions& options = {})
      : options_(options), smoother_(options.smoother) {}

  /// Applies a change. Hybrid factors of one discrete variable are choices; those between a planar
  /// pose and the next stay open until closures decide. Errors as those of
  /// IncrementalSmoother::update. Factors that are kept back have no handles in the report.
  UpdateReport update(const Delta& delta);

  /// Adds all closures kept back, converges, and tries choices again until none changes.
  UpdateReport finish();

  const IncrementalSmoother& smoother() const { return smoother_; }
  int trials() const { return trials_; }  ///< other values of choices tried so far
  /// Number of closures kept back until choices are decided.
  std::size_t waiting() const;

 private:
  struct Choice {
    DiscreteKey key;
    HybridFactorPtr factor;
  };
  /// Choices that common closures span, their remaining joint values, and these closures.
  struct Group {
    std::vector<std::size_t> choices;
    std::vector<std::vector<int>> values;  // joint values, the best first: a value of each choice
    std::vector<ContinuousFactorPtr> closures;
    bool compared = false;  // with all these closures
  };

  /// The state outside the smoother that a change may alter; choices are only added.
  struct State {
    std::size_t choices = 0;
    std::vector<std::size_t> open;
    std::vector<Group> groups;
    double explained = 0.0, settled = 0.0;
    int trials = 0;
  };

  template <class Change>
  UpdateReport all_or_nothing(const Change& change);
  void take_in(Delta delta, UpdateReport& report);
  std::vector<ContinuousFactorPtr> keep_back(Delta& delta) const;
  bool is_chained(const Delta& delta) const;
  std::vector<std::size_t> spanned(const ContinuousFactor& closure) const;
  Group& join(const std::vector<std::size_t>& choices);
  void extend(Group& group, std::size_t choice);
  void compare(Group& group);
  bool settled(const Group& group) const;
  void let_in(std::size_t group);
  void let_all_in();
  void take(const Group& group);
  int value_of(std::size_t choice) const;
  std::vector<std::size_t> strained() const;
  bool resolve();
  bool try_value(std::size_t choice, int value);
  bool is_better(DiscreteKey key, int value);
  void hold(DiscreteKey key, int value);
  void lift();

  DelayedDecisionOptions options_;
  IncrementalSmoother smoother_;
  std::vector<Choice> choices_;
  std::vector<std::size_t> open_;  // choices that alone connect the poses on both sides
  std::vector<Group> groups_;      // of open choices
  Attempts attempts_;
  double explained_ = 0.0;  // expected cost, by noise, of factors added since the last update
  Handle held_;
  double settled_ = 0.0;  // continuous cost after the last update
  int trials_ = 0;
};

}  // namespace hybrid
