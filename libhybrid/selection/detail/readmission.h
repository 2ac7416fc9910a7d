// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, the hybrid mapping authors
#pragma once

#include <Eigen/Core>
#include <memory>
#include <vector>

#include "libhybrid/closures/problem.h"
#include "libhybrid/selection/detail/candidate.h"
#include "libhybrid/selection/detail/closure_front.h"
#include "libhybrid/selection/evidence.h"
#include "libhybrid/selection/innovation.h"
#include "libhybrid/selection/selection_options.h"
#include "libhybrid/solvers/problem.h"
#include "libhybrid/solvers/starts.h"

namespace hybrid {

/// The state of select_closures: the admitted closures, the map given these, and its predictions.
class Readmission {
 public:
  Readmission(const RobustProblem& problem, const ClosureSelectionOptions& options);

  /// The state that a failed macro-step restores.
  struct Snapshot {
    Problem::State state;
    std::vector<bool> accepted;
    double objective = 0.0;
  };

  void begin();
  /// Begins anew with the closures that agree with the present values.
  void begin_again() { trust(Values(values_)); }
  /// Eq. 6 with outliers of constant density, that of eq. 17 at a zero residual, so that rejected
  /// closures have no influence on the poses.
  double objective() const { return objective_; }
  Snapshot snapshot() const { return {state_, accepted_, objective_}; }
  void restore(const Snapshot& snapshot);
  /// Whether a factorisation costs little with this batch, or not much more than without it. False
  /// closures between many places fill the system, and a smaller batch shows most of them as false.
  bool affords(const std::vector<Candidate>& batch) const;
  void admit(const std::vector<Candidate>& batch);
  void drop(const std::vector<int>& closures);
  /// Solves again from chordal initial values, and keeps the better of the two maps.
  void unfold();
  /// Whether noise explains the map, see is_explained_by_noise.
  bool is_explained() const { return is_explained_by_noise(*problem_, state_); }
  /// Excludes a closure until begin_again().
  void refuse(int closure) { refused_[closure] = true; }

  /// Closures whose evidence exceeds the threshold, best first.
  std::vector<Candidate> candidates();
  /// Open closures beyond a batch that agree with it by short paths, see ClosureFront; none if
  /// fewer closures are open than the batch has, since these are predicted sooner.
  std::vector<Candidate> beyond(const std::vector<Candidate>& batch);
  /// Open closures that agree with others near them, see ClosureFront, so that their joint evidence
  /// suffices for all of them.
  std::vector<Candidate> clusters();
  /// Closures inside the gate, with the present variance factor, whatever their evidence, best
  /// first.
  std::vector<Candidate> all_plausible();
  /// The two closures whose joint evidence is best, if it suffices for two; else none.
  std::vector<Candidate> best_pair();
  /// Closures that fit but have too little information to reach the threshold however well they
  /// fit, such as those of a file that states none. From then on candidates() has these, too.
  std::vector<Candidate> uninformative();
  /// Admitted closures that the others contradict, worst first. If `tested` is given, those that
  /// are not in it have to reach the threshold.
  std::vector<int> contradicted(const std::vector<bool>* tested = nullptr) const;

  /// Solves to the end and fills in all but method and time.
  void finish(RobustResult& result);

 private:
  double work(const std::vector<bool>& accepted) const;
  void chain();
  void settle(const SolverOptions& solver);
  void assess_accepted();
  void trust(const Values& values);
  std::vector<bool> open_closures() const;
  ClosureFront::Known known(const std::vector<bool>& open) const;
  void predict_others(bool all);
  std::vector<Candidate> above_threshold() const;
  double threshold() const;
  double informative() const;
  double needed(std::size_t k) const;
  bool is_informative(const ContinuousFactor& closure) const;
  void weigh(std::size_t k, const Eigen::MatrixXd& S);
  double pair_evidence(const Candidate& a, const Candidate& b);
  void first_variance_factor();
  bool is_excluded(std::size_t k) const;
  void drop_ambiguous(const Values& values);
  void weigh_alternatives();

  const RobustProblem& closure_problem_;
  const ClosureSelectionOptions& options_;
  SolverOptions rough_;  // between macro-steps
  HybridGraph graph_;
  std::unique_ptr<Problem> problem_;
  std::unique_ptr<InnovationPredictor> predictor_;
  WorkerPool pool_;
  std::unique_ptr<ClosureFront> front_;  // null if no closure measures a relative pose
  EvidenceModel model_;
  Problem::State state_;
  Values values_;
  std::vector<bool> accepted_, refused_;
  int accepted_count_ = 0;
  double trusted_normalizer_ = 0.0;
  std::vector<double> inlier_constant_, outlier_constant_;  // contributions to the objective
  double objective_ = 0.0;
  int iterations_ = 0;
  bool converged_ = true;
  std::string message_;
  bool asks_uninformative_ = false;

  std::vector<double> evidence_;    // of each closure given all others
  std::vector<double> attainable_;  // of each if it fitted perfectly
  std::vector<double> redundancy_;  // the same
  std::vector<Eigen::VectorXd> innovation_;
  /// Predicted covariance of the innovation when last computed. It shrinks as closures are
  /// admitted, apart from changes of the linearisation, so closures far outside the gate need no
  /// new one. Empty if unknown.
  std::vector<Eigen::MatrixXd> predicted_;
  int settled_ = 0;         // how often the map was solved
  std::vector<int> asked_;  // settled_ when each closure was predicted last
};

}  // namespace hybrid
