// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, the hybrid mapping authors
#pragma once

#include <Eigen/Core>
#include <cstddef>
#include <unordered_map>
#include <vector>

#include "libhybrid/closures/alternatives.h"
#include "libhybrid/closures/closure_decision.h"
#include "libhybrid/closures/mixture_graph.h"
#include "libhybrid/smoother/incremental.h"

namespace HYBRID_API hybrid {

/// Closures that may be false, each a mixture in a smoother (eq. 16-17), and their switches: free,
/// or fixed to one of the two components by a table that forbids the other. They are numbered in
/// the order in which they come.
class SwitchedClosures {
 public:
  enum class SwitchState { kFree, kFixedInlier, kFixedOutlier };
  struct Closure {
    ContinuousFactorPtr factor;
    SwitchState switch_state = SwitchState::kFixedOutlier;
    Handle table;               // fixes the switch
    bool failed = false;        // the last attempt to admit it, since all were evaluated
    Eigen::MatrixXd predicted;  // covariance of its innovation, as last predicted, or empty
    // As of the last evaluation of all closures, or with the evidence as last predicted.
    ClosureDecision decision;
  };

  explicit SwitchedClosures(const MixtureOptions& mixture) : mixture_(mixture) {}

  bool empty() const { return closures_.empty(); }
  std::size_t size() const { return closures_.size(); }
  const Closure& operator[](std::size_t k) const { return closures_[k]; }
  std::vector<Closure>::const_iterator begin() const { return closures_.begin(); }
  std::vector<Closure>::const_iterator end() const { return closures_.end(); }
  const Alternatives& alternatives() const { return alternatives_; }
  /// Number of closures fixed as outliers.
  std::size_t out() const { return out_; }
  /// The squared residual at which the mixture of a closure switches.
  double switch_at(std::size_t k) const;
  /// Whether a closure is out, and it was not tried in vain since all were evaluated.
  bool may_be_tried(std::size_t k) const {
    return closures_[k].switch_state == SwitchState::kFixedOutlier && !closures_[k].failed;
  }

  /// A closure for modification; its state before the current change is kept.
  Closure& edit(std::size_t k);
  /// Adds a closure, fixed as an outlier, to a change of the smoother: an alternative of the
  /// closure `first`, alone if that is its own number.
  void add(const ContinuousFactorPtr& factor, std::size_t first, Delta& delta);
  /// Fixes the switch of a closure, or frees it, within a change of the smoother.
  void set_switch(std::size_t k, SwitchState switch_state, Delta& delta);
  /// Frees the switch of a closure with the next change.
  void free(std::size_t k);
  /// Makes such a change, and notes the tables that it makes. Throws Refused if the system is
  /// singular.
  UpdateReport apply(Delta delta, IncrementalSmoother& smoother);

  /// From here on all is kept as it is now, until the next change begins.
  void begin_change();
  /// Goes back to that.
  void undo_change();
  /// What an attempt with one closure may change.
  struct Before {
    std::size_t closure = 0;
    Closure state;
    std::vector<Handle> lifted;
    std::size_t out = 0;
  };
  Before before(std::size_t k);
  void take_back(Before before);

 private:
  MixtureOptions mixture_;
  std::vector<Closure> closures_;
  Alternatives alternatives_;
  std::size_t out_ = 0;
  std::vector<Handle> lifted_;        // tables to remove with the next update
  std::vector<std::size_t> changed_;  // switches with new tables in the current delta
  struct {
    std::unordered_map<std::size_t, Closure> edited;
    std::size_t size = 0, out = 0;
    std::vector<Handle> lifted;
  } saved_;  // as before the current change
};

}  // namespace hybrid
