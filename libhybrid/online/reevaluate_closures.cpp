// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, the hybrid mapping authors
// Evaluation of all closures by the online selection.
#include <memory>
#include <set>
#include <utility>

#include "libhybrid/core/infinity.h"
#include "libhybrid/core/key_letters.h"
#include "libhybrid/online/detail/evaluation.h"
#include "libhybrid/online/online_selection.h"
#include "libhybrid/smoother/transaction.h"

namespace hybrid {
namespace {

/// All closures are evaluated again when their number, or that of those left out, exceeds this many
/// times that of the last evaluation, plus some, before which there is little to decide otherwise.
constexpr std::size_t kGrowth = 4, kFirstEvaluated = 40;

bool has_grown(std::size_t now, std::size_t last) {
  return now > kGrowth * last + kFirstEvaluated;
}

/// Values are as good as others where they cost no more than this, in units of the objective.
constexpr double kAsGood = 1.0;

}  // namespace

/// The robust problem of all factors so far, with the components of trusted hybrid factors that the
/// assignment of an estimate chooses, from its values.
RobustProblem OnlineSelection::problem(const Estimate& estimate) const {
  RobustProblem problem;
  problem.initial = estimate.values;
  smoother_.graph().continuous().for_each(
      [&](Handle, const ContinuousFactorPtr& factor) { problem.trusted.push_back(factor); });
  smoother_.graph().hybrid().for_each([&](Handle, const HybridFactorPtr& factor) {
    if (factor->discrete_keys()[0].key.letter() == key_letter::kClosureSwitch) return;
    const Component component = factor->given(estimate.assignment);
    if (component.factor != nullptr) problem.trusted.emplace_back(factor, component.factor);
  });
  for (const SwitchedClosures::Closure& closure : closures_)
    problem.closures.push_back(closure.factor);
  problem.alternatives = closures_.alternatives();
  return problem;
}

JudgedClosures OnlineSelection::judged_closures() const {
  JudgedClosures judged;
  for (std::size_t k = 0; k < closures_.size(); ++k) {
    judged.factors.push_back(closures_[k].factor);
    judged.accepted.push_back(accepted(k));
  }
  return judged;
}

bool OnlineSelection::evaluating() const {
  return evaluation_.get() != nullptr && !evaluation_->adopted;
}

/// Begins an evaluation of all closures if it is time, and goes on with the one under way. With
/// choices, which it may change, it is made at once.
void OnlineSelection::go_on_evaluating(SelectionReport& report) {
  if (evaluation_.get() == nullptr) {
    const bool is_due =
        has_grown(closures_.size(), evaluated_) || has_grown(closures_.out(), left_out_);
    if (!is_due || waiting() > 0) return;
    evaluation_.begin(std::make_unique<ClosureEvaluation>(
        problem(smoother_.estimate()), judged_closures().accepted, options_.selection));
  }
  const double share = choices_.empty() ? options_.spread * work_ / updates_ : kInfinity;
  try {
    if (!evaluation_->task.advance(share)) return;
  } catch (...) {
    evaluation_.drop();
    throw;
  }
  evaluation_->adopted = true;
  SwitchedClosures closures = closures_;
  State before = state();
  const int admitted = report.admitted;
  const auto adopt_all = [&] {
    adopt_evaluation(evaluation_->result, report);
    return true;
  };
  if (attempt(smoother_, adopt_all)) return;
  closures_ = std::move(closures);
  restore(std::move(before));
  report.admitted = admitted;
}

/// Evaluates all closures from scratch; or from the present map, if the last evaluation from
/// scratch is recent.
void OnlineSelection::reevaluate_all(SelectionReport& report) {
  RobustProblem problem = this->problem(smoother_.estimate());
  if (closures_.size() > evaluated_) {
    adopt_evaluation(evaluate_closures(problem, judged_closures().accepted, options_.selection),
                     report);
  } else {
    ClosureSelectionOptions present = options_.selection;
    present.trust_start = true;
    adopt_evaluation(select_closures(problem, present), report);
  }
}

void OnlineSelection::adopt_evaluation(RobustResult best, SelectionReport& report) {
  evaluated_ = best.decisions.size();
  adopt(best, report);
  left_out_ = closures_.out();
  judged_ = evaluated_ == closures_.size();
  if (judged_) revise_by_closures(best, report);
  variance_factor_ = best.variance_factor;
  for (std::size_t k = 0; k < evaluated_; ++k) closures_.edit(k).decision = best.decisions[k];
  open_ = !judged_;
}

/// Gives doubted choices other values: all closures are evaluated again under these, and they are
/// kept if the joint objective falls. `present` is the last such evaluation.
void OnlineSelection::revise_by_closures(RobustResult& present, SelectionReport& report) {
  std::set<std::pair<std::vector<std::size_t>, std::vector<int>>> tried;
  for (bool again = true; again;) {
    again = false;
    const JudgedClosures closures = judged_closures();
    for (const std::vector<std::size_t>& choices : choices_.doubted(closures)) {
      const ChoiceGroup group = choices_.compare_again(choices, closures, smoother_);
      if (!choices_.differs(group, smoother_)) continue;
      if (!tried.emplace(group.choices, group.values[0]).second) continue;
      const RobustProblem other = problem(choices_.with(group, smoother_));
      RobustResult result = select_closures(other, options_.selection);
      if (!(result.objective < present.objective)) continue;
      choices_.take(group, smoother_);
      adopt(result, report);
      present = std::move(result);
      tried.clear();  // what was refused may pass now
      again = true;
      break;
    }
  }
}

/// Takes over values, unless the smoother has come to as good ones.
void OnlineSelection::go_to(const Values& values) {
  const double there = objective(smoother_.graph(), values, smoother_.assignment());
  if (smoother_.objective() <= there + kAsGood) return;
  IncrementalSmoother::Snapshot estimate{smoother_.values().keys(), {}};
  for (Key key : estimate.keys) {
    const double* x = values.data(key);
    estimate.numbers.insert(estimate.numbers.end(), x, x + values.type(key).size);
  }
  taken(smoother_.restore(estimate));
}

/// Adopts the decisions and values of a result of select_closures.
void OnlineSelection::adopt(const RobustResult& result, SelectionReport& report) {
  using SwitchState = SwitchedClosures::SwitchState;
  Delta delta;
  std::vector<std::size_t> in;
  for (std::size_t k = 0; k < result.decisions.size(); ++k) {
    SwitchedClosures::Closure& closure = closures_.edit(k);
    const bool accept = result.decisions[k].accepted();
    if (accept) in.push_back(k);
    const SwitchState wanted = accept ? SwitchState::kFixedInlier : SwitchState::kFixedOutlier;
    if (closure.switch_state == wanted) continue;
    if (accept && !accepted(k)) ++report.admitted;
    closures_.set_switch(k, wanted, delta);
  }
  report.add(closures_.apply(std::move(delta), smoother_));
  go_to(grown(result.values, smoother_));
  for (std::size_t k : in) {
    if (2.0 * closures_[k].factor->cost(smoother_.values()) < closures_.switch_at(k))
      closures_.free(k);
  }
  for (std::size_t k = 0; k < closures_.size(); ++k) {
    SwitchedClosures::Closure& closure = closures_.edit(k);
    closure.failed = false;
    closure.predicted.resize(0, 0);  // covariances may have grown
  }
}

}  // namespace hybrid
