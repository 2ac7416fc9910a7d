// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, the hybrid mapping authors
#pragma once

#include <cstddef>
#include <optional>
#include <unordered_map>
#include <vector>

#include "libhybrid/closures/mixture_graph.h"
#include "libhybrid/closures/problem.h"
#include "libhybrid/selection/attempts.h"
#include "libhybrid/selection/closure_selection.h"
#include "libhybrid/selection/odometry_path.h"
#include "libhybrid/selection/prediction.h"
#include "libhybrid/selection/variance_factor.h"
#include "libhybrid/smoother/incremental.h"

namespace HYBRID_API hybrid {

struct OnlineClosureSelectionOptions {
  OnlineClosureSelectionOptions() {
    mixture.flat = true;
    smoother.relinearize = 3e-2;
    smoother.wildfire = 1e-3;
  }

  MixtureOptions mixture;
  /// Closures are admitted within this quantile of their predicted innovation, given the odometry
  /// alone and given all accepted measurements.
  double gate = 0.999;
  /// Closures of less redundancy are reported as uncheckable.
  double min_redundancy = 0.09;
  SmootherOptions smoother;
  ClosureSelectionOptions selection;  ///< for evaluations of all closures
};

/// The present decision on a closure.
enum class ClosureStatus {
  kRejectedByOdometry,  ///< contradicts the odometry
  kUndecided,           ///< agrees with the odometry, but not with the map
  kAccepted
};

/// Report of one step of the selection.
struct SelectionReport : UpdateReport {
  int admitted = 0;  ///< closures admitted
  int tried = 0;     ///< attempts to admit a closure

  /// Adds the report of a further update of the smoother.
  void add(const UpdateReport& update);
};

/// Selects among loop closures that arrive pose by pose and may be false, on the incremental
/// smoother.
///
/// A closure enters as a mixture (eq. 16-17) fixed to its outlier component, which couples no
/// poses. It is admitted if its innovation agrees with the odometry alone, so that closures that
/// agree with each other but not with the odometry stay out, and with the map, by the predicted
/// covariance S = I + A P A'; and only if the joint objective of eq. 6 falls. From then on its
/// switch is free: the discrete half-step rejects it when later measurements contradict it. The
/// newest closures that are not admitted are tested again when the map has changed. Whenever the
/// number of closures has grown fourfold, and in finish(), all are evaluated again from scratch by
/// select_closures, which can reverse any decision; the earlier evaluations together cost about a
/// third of the last one.
///
/// Every change is all or nothing, as those of IncrementalSmoother: if it throws, or its report
/// says that the system is singular, nothing has changed.
class OnlineClosureSelection {
 public:
  explicit OnlineClosureSelection(const OnlineClosureSelectionOptions& options = {});

  /// Applies a change of trusted factors, and tests the closures that come with it. They are
  /// numbered in the order in which they arrive. Errors as those of IncrementalSmoother::update,
  /// and for discrete variables with the letter of the switches of closures (see closure_switch).
  SelectionReport update(const Delta& trusted, const std::vector<ContinuousFactorPtr>& closures);

  /// Evaluates all closures again, from scratch or from the present map, and converges.
  SelectionReport finish();

  const IncrementalSmoother& smoother() const { return smoother_; }
  ClosureStatus status(std::size_t closure) const;
  /// Verdicts by closure, at the present estimate. Directly after an evaluation of all closures
  /// they are those of the evaluation; else redundancies are those of the closures that the
  /// odometry does not contradict.
  std::vector<Verdict> verdicts() const;

 private:
  enum class SwitchState { kFree, kFixedInlier, kFixedOutlier };
  struct Closure {
    ContinuousFactorPtr factor;
    SwitchState switch_state = SwitchState::kFixedOutlier;
    Handle table;                     // fixes the switch
    bool refuted = false;             // by the odometry
    int failures = 0;                 // attempts to admit it that did not lower the objective
    Prediction innovation;            // as last predicted, given the map
    std::optional<Prediction> alone;  // given the odometry alone
  };

  /// The state that a change may alter, besides the smoother and earlier closures.
  struct State {
    std::size_t poses = 0, closures = 0;
    VarianceFactor factor_alone, factor;
    std::size_t expelled_at = 0, evaluated = 0;
    std::vector<std::size_t> open;
    std::vector<Handle> lifted;
    std::vector<Verdict> verdicts;
  };

  template <class Change>
  SelectionReport all_or_nothing(const Change& change);
  State save();
  void restore(State&& before);
  Closure& edit(std::size_t k);
  void take_in(const Delta& trusted, const std::vector<ContinuousFactorPtr>& closures,
               SelectionReport& report);
  void follow(const Delta& trusted);
  void set_switch(std::size_t k, SwitchState switch_state, Delta& delta);
  UpdateReport apply(Delta delta);
  bool accepted(std::size_t k) const;
  Prediction predict(const ContinuousFactor& closure) const;
  bool refuted(const Closure& closure) const;
  double switch_at(std::size_t k) const;
  bool consider(std::size_t k, SelectionReport& report);
  void reconsider(SelectionReport& report);
  void expel(SelectionReport& report);
  bool admit(std::size_t k, SelectionReport& report);
  bool is_better_with(std::size_t k, SelectionReport& report);
  void withdraw(std::size_t k, const std::vector<bool>& before,
                const IncrementalSmoother::Snapshot& estimate);
  RobustProblem problem() const;
  double noise(const Values& values, const std::vector<bool>& in) const;
  void reevaluate_all(SelectionReport& report);
  void adopt(const RobustResult& result, SelectionReport& report);
  void free(std::size_t k);

  OnlineClosureSelectionOptions options_;
  IncrementalSmoother smoother_;
  OdometryPath odometry_;
  VarianceFactor factor_alone_, factor_;
  std::size_t expelled_at_ = 0;  // size of open_ at the last search for closures to expel
  std::vector<Closure> closures_;
  std::vector<std::size_t> open_;              // not refuted
  std::vector<std::size_t> changed_switches_;  // switches with new tables in the current delta
  std::vector<Handle> lifted_;                 // tables to remove with the next update
  std::size_t evaluated_ = 0;                  // number of closures when all were evaluated last
  std::vector<Verdict> verdicts_;              // of that evaluation; empty once outdated
  Attempts attempts_;
  std::unordered_map<std::size_t, Closure> saved_;  // closures as before the current change
};

}  // namespace hybrid
