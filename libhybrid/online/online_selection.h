// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, the hybrid mapping authors
#pragma once

#include <cstddef>
#include <memory>
#include <vector>

#include "libhybrid/choices/choices.h"
#include "libhybrid/closures/alternatives.h"
#include "libhybrid/closures/mixture_graph.h"
#include "libhybrid/closures/problem.h"
#include "libhybrid/core/option.h"
#include "libhybrid/online/switched_closures.h"
#include "libhybrid/selection/closure_selection.h"
#include "libhybrid/smoother/incremental.h"

namespace HYBRID_API hybrid {

struct ClosureEvaluation;
struct EvidenceModel;
struct Innovation;

struct OnlineSelectionOptions {
  OnlineSelectionOptions() {
    mixture.flat = true;
    smoother.relinearize = 3e-2;
    smoother.wildfire = 1e-3;
  }

  MixtureOptions mixture;
  /// Other values of the choices of largest cost are tried when an update raises the cost of the
  /// graph by more than this beyond its expected rise by noise.
  double decisive = 10.0;
  std::size_t patience = 40;
  SmootherOptions smoother;
  ClosureSelectionOptions selection;
  double spread = 10.0;

  template <class Table>
  static void describe(Table& table) {
    using O = OnlineSelectionOptions;
    table.field("mixture", &O::mixture, "the model of false closures");
    table.option(
        "decisive", &O::decisive, {0.0, 1e3},
        "a joint value of hypotheses of this much less log evidence than the best is dropped");
    table.option("patience", &O::patience, {1, 1e6},
                 "closures kept back at which the best joint value of hypotheses is taken");
    table.option("spread", &O::spread, {0.1, 1e9},
                 "evaluations of all closures, and tests of earlier ones, go on with each pose by "
                 "so many times the work of a mean pose");
    table.field("smoother", &O::smoother, "settings of the smoother");
    table.field("selection", &O::selection,
                "settings of the tests of closures and of the evaluation of all of them");
  }
};

/// Report of one step of the selection.
struct SelectionReport : UpdateReport {
  int admitted = 0;  ///< closures admitted
  int tried = 0;     ///< attempts to admit a closure

  /// Adds the report of a further update of the smoother.
  void add(const UpdateReport& update);
};

/// Selects online among loop closures that may be false, and decides about measurements with
/// several hypotheses (choices), on the incremental smoother.
///
/// A closure enters as a mixture (eq. 16-17) fixed to its outlier component, which couples no
/// poses. It is admitted if its evidence, by the covariance S = I + A P A' that the map predicts
/// for its innovation, exceeds the threshold of select_closures (see EvidenceModel), and only if
/// the joint objective of eq. 6 falls. From then on its switch is free: the discrete half-step
/// rejects it when later measurements contradict it. The newest closures that are not admitted are
/// tested again when the map has changed. Whenever the number of closures, or of those that are
/// not admitted, has grown fourfold, and in finish(), all are evaluated again from scratch by
/// select_closures, which can reverse any decision: what one closure does not prove many may prove
/// together. The earlier evaluations that the number of closures asks for cost about a third of the
/// last one. They are spread over the updates that follow, and adopted when they are done: what has
/// come since then moves along, and its closures keep their state.
///
/// Closures that span open choices wait until these are decided, see Choices. Those that are
/// decided and that closures contradict are tried at other values, with all closures evaluated
/// under these.
///
/// Every change is all or nothing, as those of IncrementalSmoother: if it throws, or its report
/// says that the system is singular, nothing has changed.
class OnlineSelection {
 public:
  explicit OnlineSelection(const OnlineSelectionOptions& options = {});

  /// Applies a change of trusted factors, and tests the closures that come with it. They are
  /// numbered in the order in which they arrive. Hybrid factors of one discrete variable are
  /// choices; those between a pose and the next stay open until closures decide. Trusted closures
  /// that are kept back have no handles in the report. `alternatives` are those among the closures
  /// of this update. Errors as those of IncrementalSmoother::update, and for discrete variables
  /// with the letter of the switches of closures (see closure_switch).
  SelectionReport update(const Delta& trusted,
                         const std::vector<ContinuousFactorPtr>& closures = {},
                         const Alternatives& alternatives = {});

  /// Lets in all closures kept back, evaluates all that may be false again, from scratch or from
  /// the present map, converges, and tries choices again until none changes.
  SelectionReport finish();

  const IncrementalSmoother& smoother() const { return smoother_; }
  /// Rejected, undecided or accepted, at present. Throws Error if there is no such closure.
  ClosureStatus status(std::size_t closure) const;
  /// Verdicts by closure, at the present estimate. Directly after an evaluation of all closures
  /// they are those of the evaluation; else each is made of one covariance.
  std::vector<ClosureDecision> decisions() const;
  int trials() const { return choices_.trials(); }  ///< other values of choices tried so far
  /// Number of closures kept back until choices are decided.
  std::size_t waiting() const { return choices_.waiting(); }
  /// Whether an evaluation of all closures is under way.
  bool evaluating() const;

 private:
  /// An evaluation of all closures. A copy of the selection begins it anew.
  class UnderWay {
   public:
    UnderWay();
    ~UnderWay();
    UnderWay(const UnderWay&);
    UnderWay(UnderWay&&) noexcept;
    UnderWay& operator=(UnderWay) noexcept;
    void begin(std::unique_ptr<ClosureEvaluation> evaluation);
    void drop();
    ClosureEvaluation* get() const { return evaluation_.get(); }
    ClosureEvaluation* operator->() const { return get(); }

   private:
    std::unique_ptr<ClosureEvaluation> evaluation_;
  };
  /// The state that a change may alter, besides the smoother and the closures.
  struct State {
    std::size_t evaluated = 0, left_out = 0;
    bool judged = false;
    Choices::State choices;
    double variance_factor = 1.0, radius = 0.0;
    std::size_t measured_at = 0;
    const ClosureEvaluation* evaluation = nullptr;
    double work = 0.0, updates = 0.0;
    bool open = false;
  };

  template <class Change>
  SelectionReport all_or_nothing(const Change& change);
  State state() const;
  void restore(State&& before);
  void take_in(Delta trusted, const std::vector<ContinuousFactorPtr>& closures,
               const Alternatives& alternatives, SelectionReport& report);

  // Closures.
  bool accepted(std::size_t k) const;
  void ask(std::size_t k, SelectionReport& report);
  EvidenceModel evidence_model() const;
  double threshold() const;
  void measure_map();
  Innovation innovation_against(std::size_t k) const;
  bool consider(std::size_t k, SelectionReport& report);
  bool stands_out(std::size_t k) const;
  bool reconsider(SelectionReport& report);
  bool is_long() const;
  bool admit(std::size_t k, SelectionReport& report);
  bool is_better_with(std::size_t k, SelectionReport& report);
  std::vector<ClosureDecision> judge() const;
  RobustProblem problem(const Estimate& estimate) const;
  JudgedClosures judged_closures() const;
  void go_on_evaluating(SelectionReport& report);
  void reevaluate_all(SelectionReport& report);
  void adopt_evaluation(RobustResult best, SelectionReport& report);
  void go_to(const Values& values);
  void adopt(const RobustResult& result, SelectionReport& report);

  // Choices.
  void let_in(const std::vector<WaitingClosure>& closures, SelectionReport& report);
  void revise_by_closures(RobustResult& present, SelectionReport& report);

  OnlineSelectionOptions options_;
  IncrementalSmoother smoother_;
  double variance_factor_ = 1.0;  // of the last evaluation of all closures
  double radius_ = 0.0;           // of the map when it had measured_at_ variables [m]
  std::size_t measured_at_ = 0;
  SwitchedClosures closures_;
  std::size_t evaluated_ = 0;          // number of closures when all were evaluated last
  std::size_t left_out_ = 0;           // of them, after that
  UnderWay evaluation_;                // under way, or adopted by the last change
  double work_ = 0.0, updates_ = 0.0;  // of all updates, evaluations left out
  double work_before_ = 0.0;           // noted by the thread before the update under way
  bool open_ = false;                  // whether closures are to be tested again
  bool judged_ = false;  // whether the decisions on all closures are of that evaluation
  Choices choices_;
};

}  // namespace hybrid
