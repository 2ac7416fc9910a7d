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
  /// Joint values of open choices that are less likely than the best by this much (in -log) are
  /// given up.
  double margin = 15.0;
  /// Closures that may be kept back before the best joint value is taken, however close the next.
  std::size_t patience = 40;
  /// Choices under strain are tried when an update raises the cost of the graph by more than this
  /// beyond what noise explains.
  double surprise = 10.0;
  SmootherOptions smoother;
};

/// Measurements with several hypotheses, decided online. A wrong choice costs nothing until the
/// robot comes back to where it has been, and then spreads over the whole loop, so that no choice
/// looks better than the one made: the alternation of eq. 8 is stuck. So closures that span open
/// choices are kept back, and do not bend the map, until they have told the joint values of these
/// choices apart (ChoiceComparison): only then do they enter, with the joint value that is left.
/// Choices that no common closure spans are told apart by themselves, so that the number of joint
/// values stays small. Where the cost of the map rises all the same, choices that are under strain
/// are held at their other values, one by one, and kept there where the joint objective of eq. 6
/// falls. So every choice can be tried again.
///
/// Every change is all or nothing, as those of IncrementalSmoother: where it throws, or its report
/// says that the system is singular, all is as it was before.
class DelayedDecisionSmoother {
 public:
  explicit DelayedDecisionSmoother(const DelayedDecisionOptions& options = {})
      : options_(options), smoother_(options.smoother) {}

  /// Applies a change. Hybrid factors of one discrete variable are choices; those between a planar
  /// pose and the next stay open until closures decide. Errors as those of
  /// IncrementalSmoother::update. Factors that are kept back have no handles in the report.
  UpdateReport update(const Delta& delta);

  /// Lets all closures in, converges, and tries choices again until none changes.
  UpdateReport finish();

  const IncrementalSmoother& smoother() const { return smoother_; }
  int trials() const { return trials_; }  ///< values of strained choices tried so far
  /// Closures that wait for choices to be told apart.
  std::size_t waiting() const;

 private:
  struct Choice {
    DiscreteKey key;
    HybridFactorPtr factor;
  };
  /// Choices that closures tie together, the joint values not given up, and these closures.
  struct Group {
    std::vector<std::size_t> choices;
    std::vector<std::vector<int>> values;  // by joint value: of each choice; the best first
    std::vector<ContinuousFactorPtr> closures;
    bool compared = false;  // with all these closures
  };

  /// What a change moves beside the smoother; choices are only added.
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
  std::vector<std::size_t> open_;  // choices over which nothing but themselves connects the poses
  std::vector<Group> groups_;      // of open choices
  Attempts attempts_;
  double explained_ = 0.0;  // cost that the noise of what has entered since explains
  Handle held_;
  double settled_ = 0.0;  // continuous cost after the last update
  int trials_ = 0;
};

}  // namespace hybrid
