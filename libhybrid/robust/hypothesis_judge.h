// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, the hybrid mapping authors
#pragma once

#include <vector>

#include "libhybrid/smoother/incremental.h"

namespace hybrid {

struct HypothesisJudgeOptions {
  HypothesisJudgeOptions() {
    smoother.relinearize = 3e-2;
    smoother.wildfire = 1e-3;
  }
  /// Choices under strain are tried when an update raises the cost of the graph by more than this.
  double surprise = 10.0;
  SmootherOptions smoother;
};

/// Measurements with several hypotheses, decided online. A wrong choice costs nothing until the
/// robot comes back to where it has been, and then spreads over the whole loop, so that no choice
/// looks better than the one made: the alternation of eq. 8 is stuck. So choices that no closure
/// has spanned yet are settled before a closure that spans them bends the map: what hangs on an
/// open choice moves rigidly with it, and the joint value that suits the closures best is taken.
/// Where the cost rises all the same, choices that are under strain are held at their other values,
/// one by one, and kept there where the joint objective of eq. 6 falls. Nothing is pruned: every
/// choice can be tried again.
class HypothesisJudge {
 public:
  explicit HypothesisJudge(const HypothesisJudgeOptions& options = {})
      : options_(options), smoother_(options.smoother) {}

  /// Applies a change. Hybrid factors of one discrete variable are choices. Errors as those of
  /// IncrementalSmoother::update.
  UpdateReport update(const Delta& delta);

  /// Converges, and tries choices again until none changes.
  UpdateReport finish();

  const IncrementalSmoother& smoother() const { return smoother_; }
  int trials() const { return trials_; }  ///< values tried so far

 private:
  struct Choice {
    DiscreteKey key;
    HybridFactorPtr factor;
  };
  struct Strained {
    double cost;
    std::size_t choice;
  };

  void anticipate(Delta& delta);
  void take(const std::vector<std::size_t>& open, const std::vector<int>& values, Delta& delta);
  void close(const Delta& delta);
  int value_of(std::size_t choice, const Delta& delta) const;
  std::vector<Strained> strained() const;
  bool resolve();
  bool try_value(const Choice& choice, int value);
  void hold(DiscreteKey key, int value);
  void lift();

  HypothesisJudgeOptions options_;
  IncrementalSmoother smoother_;
  std::vector<Choice> choices_;
  std::vector<std::size_t> open_;  // choices that no closure spans
  Handle held_;
  double settled_ = 0.0;  // continuous cost after the last update
  double normalizer_ = 0.0;
  int trials_ = 0;
};

}  // namespace hybrid
