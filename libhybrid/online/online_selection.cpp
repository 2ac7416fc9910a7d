// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, the hybrid mapping authors
#include "libhybrid/online/online_selection.h"

#include <algorithm>
#include <chrono>
#include <cmath>
#include <string>
#include <utility>

#include "libhybrid/core/chi_square.h"
#include "libhybrid/core/elapsed.h"
#include "libhybrid/core/infinity.h"
#include "libhybrid/core/key_letters.h"
#include "libhybrid/core/paced_task.h"
#include "libhybrid/online/detail/evaluation.h"
#include "libhybrid/selection/evidence.h"
#include "libhybrid/selection/innovation.h"
#include "libhybrid/smoother/transaction.h"

namespace hybrid {
namespace {

using Clock = std::chrono::steady_clock;

/// Throws Error if a discrete variable has the letter of the switches of closures.
void check_names(const Delta& trusted) {
  const auto check = [](Key key) {
    if (key.letter() != key_letter::kClosureSwitch) return;
    throw Error("discrete variable " + to_string(key) + ": the letter " +
                std::string(1, key.letter()) +
                " is that of the switches of closures; take another letter for it");
  };
  for (const HybridFactorPtr& factor : trusted.hybrid) {
    if (factor == nullptr) continue;
    for (const DiscreteKey& key : factor->discrete_keys()) check(key.key);
  }
  for (const Table& table : trusted.discrete) {
    for (const DiscreteKey& key : table.keys()) check(key.key);
  }
  for (const auto& [key, value] : trusted.assignment) check(key);
}

}  // namespace

void SelectionReport::add(const UpdateReport& update) {
  status = update.status;
  if (!update.message.empty()) message = update.message;
  UpdateWork::add(update);
}

OnlineSelection::OnlineSelection(const OnlineSelectionOptions& options)
    : options_(options),
      smoother_(options.smoother),
      closures_(options.mixture),
      choices_({options.decisive, options.patience, options.selection}) {}

OnlineSelection::UnderWay::UnderWay() = default;
OnlineSelection::UnderWay::~UnderWay() = default;
OnlineSelection::UnderWay::UnderWay(const UnderWay&) {}
OnlineSelection::UnderWay::UnderWay(UnderWay&&) noexcept = default;

OnlineSelection::UnderWay& OnlineSelection::UnderWay::operator=(UnderWay other) noexcept {
  evaluation_ = std::move(other.evaluation_);
  return *this;
}

void OnlineSelection::UnderWay::drop() {
  evaluation_.reset();
}

void OnlineSelection::UnderWay::begin(std::unique_ptr<ClosureEvaluation> evaluation) {
  evaluation_ = std::move(evaluation);
}

/// Runs change(report) and undoes all of it if it fails.
template <class Change>
SelectionReport OnlineSelection::all_or_nothing(const Change& change) {
  const auto start = Clock::now();
  closures_.begin_change();
  if (evaluation_.get() != nullptr && evaluation_->adopted) evaluation_.drop();
  State before = state();
  const auto undo = [&] {
    closures_.undo_change();
    if (evaluation_.get() != before.evaluation) evaluation_.drop();
    if (evaluation_.get() != nullptr) evaluation_->adopted = false;
    restore(std::move(before));
  };
  SelectionReport report;
  try {
    Transaction transaction(smoother_);
    change(report);
    transaction.commit();
  } catch (const Refused& refused) {
    undo();
    static_cast<UpdateReport&>(report) = refused.report;
  } catch (...) {
    undo();
    throw;
  }
  report.objective_after = smoother_.objective();
  report.seconds = seconds_since(start);
  return report;
}

OnlineSelection::State OnlineSelection::state() const {
  return {evaluated_, left_out_,    judged_,           choices_.save(), variance_factor_,
          radius_,    measured_at_, evaluation_.get(), work_,           updates_,
          open_};
}

/// All but the closures and the evaluation.
void OnlineSelection::restore(State&& before) {
  evaluated_ = before.evaluated;
  left_out_ = before.left_out;
  judged_ = before.judged;
  choices_.restore(std::move(before.choices));
  variance_factor_ = before.variance_factor;
  radius_ = before.radius;
  measured_at_ = before.measured_at;
  work_ = before.work;
  updates_ = before.updates;
  open_ = before.open;
}

SelectionReport OnlineSelection::update(const Delta& trusted,
                                        const std::vector<ContinuousFactorPtr>& closures,
                                        const Alternatives& alternatives) {
  check_names(trusted);
  return all_or_nothing(
      [&](SelectionReport& report) { take_in(trusted, closures, alternatives, report); });
}

SelectionReport OnlineSelection::finish() {
  return all_or_nothing([&](SelectionReport& report) {
    report.objective_before = smoother_.objective();
    evaluation_.drop();
    let_in(choices_.close_all(), report);
    if (!closures_.empty()) reevaluate_all(report);
    report.add(closures_.apply({}, smoother_));
    report.add(taken(smoother_.converge()));
    while (choices_.resolve(smoother_)) report.add(taken(smoother_.converge()));
  });
}

void OnlineSelection::take_in(Delta trusted, const std::vector<ContinuousFactorPtr>& closures,
                              const Alternatives& alternatives, SelectionReport& report) {
  work_before_ = noted_work();
  const bool chained = is_chained(trusted);
  const std::vector<ContinuousFactorPtr> kept =
      chained ? choices_.keep_back(trusted, smoother_.values())
              : std::vector<ContinuousFactorPtr>();
  if (!chained) let_in(choices_.close_all(), report);
  Delta delta = trusted;
  const std::size_t first = closures_.size();
  for (const ContinuousFactorPtr& factor : closures) {
    const std::size_t k = closures_.size();
    const std::vector<std::size_t>& set = alternatives.set_of(k - first);
    closures_.add(factor, set.empty() ? k : first + set.front(), delta);
  }
  const UpdateReport done = closures_.apply(std::move(delta), smoother_);
  report.add(done);
  report.handles = done.handles;
  report.objective_before = done.objective_before;
  judged_ = false;
  choices_.note(trusted);
  if (!closures.empty()) measure_map();
  for (const ContinuousFactorPtr& closure : kept) {
    choices_.keep({closure, std::nullopt}, smoother_);
  }
  for (std::size_t k = first; k < closures_.size(); ++k) ask(k, report);
  while (const auto closures_let_in = choices_.decide_next(smoother_)) {
    let_in(*closures_let_in, report);
  }
  if (open_) open_ = reconsider(report);
  work_ += noted_work() - work_before_;
  updates_ += 1.0;
  go_on_evaluating(report);
  choices_.revise(smoother_);
}

ClosureStatus OnlineSelection::status(std::size_t closure) const {
  if (closure >= closures_.size()) {
    throw Error("there is no closure " + std::to_string(closure) + "; there are " +
                std::to_string(closures_.size()));
  }
  if (accepted(closure)) return ClosureStatus::kAccepted;
  return closures_[closure].decision.evidence < 0.0 ? ClosureStatus::kRejected
                                                    : ClosureStatus::kUndecided;
}

std::vector<ClosureDecision> OnlineSelection::decisions() const {
  std::vector<ClosureDecision> decisions;
  if (judged_) {
    for (const SwitchedClosures::Closure& closure : closures_)
      decisions.push_back(closure.decision);
  } else {
    decisions = judge();
  }
  for (std::size_t k = 0; k < decisions.size(); ++k) decisions[k].status = status(k);
  return decisions;
}

/// Decisions on all closures, each by one covariance.
std::vector<ClosureDecision> OnlineSelection::judge() const {
  JudgedClosures judged = judged_closures();
  const std::vector<bool>& in = judged.accepted;
  RobustProblem problem;
  problem.closures = std::move(judged.factors);
  std::vector<ClosureDecision> decisions =
      make_decisions(problem, smoother_.values(), in, options_.mixture);
  const EvidenceModel model = evidence_model();
  std::vector<double> evidence, redundancy;
  for (std::size_t k = 0; k < closures_.size(); ++k) {
    const ContinuousFactor& factor = *closures_[k].factor;
    const GivenOthers alone = given_others(innovation_against(k), in[k]);
    evidence.push_back(model.log_ratio(alone.b, alone.S, factor));
    redundancy.push_back(alone.redundancy);
  }
  write_evidence(evidence, redundancy, closures_.alternatives(), options_.selection, decisions);
  return decisions;
}

}  // namespace hybrid
