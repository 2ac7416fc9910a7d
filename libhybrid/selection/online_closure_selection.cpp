// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, the hybrid mapping authors
#include "libhybrid/selection/online_closure_selection.h"

#include <algorithm>
#include <chrono>
#include <cmath>
#include <utility>

#include "libhybrid/core/chi_square.h"
#include "libhybrid/core/elapsed.h"
#include "libhybrid/core/infinity.h"
#include "libhybrid/core/key_letters.h"

namespace hybrid {
namespace {

/// Updates within which an admitted closure must lower the objective.
constexpr int kSettle = 6;
/// An attempt ends when an update leaves more than this share of the rise of the objective.
constexpr double kProgress = 0.8;
/// Failed attempts after which a closure waits until all are evaluated again.
constexpr int kAttempts = 1;
/// Newest closures that are tested again when the map has changed.
constexpr std::size_t kReconsidered = 50;
/// All closures are evaluated again when their number exceeds kGrowth times that of the last
/// evaluation plus kFewClosures.
constexpr std::size_t kGrowth = 4;
constexpr std::size_t kFewClosures = 20;

/// Names of attempts other than to admit closure k, which is {k, 0}.
constexpr Attempts::Name kExpel = {0, 1}, kReevaluate = {0, 2};

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

OnlineClosureSelection::OnlineClosureSelection(const OnlineClosureSelectionOptions& options)
    : options_(options), smoother_(options.smoother) {}

/// Runs change(report) and undoes all of it if it fails.
template <class Change>
SelectionReport OnlineClosureSelection::all_or_nothing(const Change& change) {
  const auto start = Clock::now();
  auto report = attempts_.run<SelectionReport>(
      smoother_, [&] { return save(); }, [&](State&& before) { restore(std::move(before)); },
      change);
  report.objective_after = smoother_.objective();
  report.seconds = seconds_since(start);
  return report;
}

OnlineClosureSelection::State OnlineClosureSelection::save() {
  saved_.clear();
  return {odometry_.size(), closures_.size(), factor_alone_, factor_,
          expelled_at_,     evaluated_,       open_,         lifted_,
          verdicts_};
}

void OnlineClosureSelection::restore(State&& before) {
  odometry_.shrink(before.poses);
  closures_.resize(before.closures);
  for (auto& [k, closure] : saved_) {
    if (k < before.closures) closures_[k] = std::move(closure);
  }
  factor_alone_ = std::move(before.factor_alone);
  factor_ = std::move(before.factor);
  expelled_at_ = before.expelled_at;
  evaluated_ = before.evaluated;
  open_ = std::move(before.open);
  lifted_ = std::move(before.lifted);
  verdicts_ = std::move(before.verdicts);
  changed_switches_.clear();
}

/// Returns a closure for modification; saves its state before the current change.
OnlineClosureSelection::Closure& OnlineClosureSelection::edit(std::size_t k) {
  saved_.try_emplace(k, closures_[k]);
  return closures_[k];
}

/// Appends new poses to the path of odometry, each by its first trusted factor from an earlier
/// pose.
void OnlineClosureSelection::follow(const Delta& trusted) {
  for (Key key : trusted.values.keys()) {
    const VariableType type = trusted.values.type(key);
    if (!is_pose(type)) continue;
    const ContinuousFactor* step = nullptr;
    for (const ContinuousFactorPtr& factor : trusted.continuous) {
      const std::vector<Key>& keys = factor->keys();
      if (keys.size() == 2 && keys[1] == key && factor->types()[0] == type) step = factor.get();
      if (step != nullptr) break;
    }
    if (step == nullptr) {
      odometry_.start(key, type, trusted.values.data(key));
    } else {
      odometry_.append(step->keys()[0], key, *step, type, trusted.values.data(key));
    }
  }
}

/// Fixes the switch of a closure by a table that forbids the other value, or frees it.
void OnlineClosureSelection::set_switch(std::size_t k, SwitchState switch_state, Delta& delta) {
  Closure& closure = edit(k);
  if (closure.table.valid()) delta.remove.push_back(closure.table);
  closure.table = {};
  closure.switch_state = switch_state;
  if (switch_state == SwitchState::kFree) return;
  delta.discrete.emplace_back(std::vector<DiscreteKey>{closure_switch(k)},
                              switch_state == SwitchState::kFixedInlier
                                  ? std::vector<double>{0.0, kInfinity}
                                  : std::vector<double>{kInfinity, 0.0});
  changed_switches_.push_back(k);
}

/// Updates the smoother; throws Refused if the system is singular.
UpdateReport OnlineClosureSelection::apply(Delta delta) {
  delta.remove.insert(delta.remove.end(), lifted_.begin(), lifted_.end());
  const UpdateReport report = taken(smoother_.update(delta));
  lifted_.clear();
  const std::size_t first = delta.discrete.size() - changed_switches_.size();
  for (std::size_t i = 0; i < changed_switches_.size(); ++i) {
    edit(changed_switches_[i]).table = report.handles.discrete[first + i];
  }
  changed_switches_.clear();
  return report;
}

bool OnlineClosureSelection::accepted(std::size_t k) const {
  return smoother_.assignment().at(closure_switch(k).key) == 0;
}

Prediction OnlineClosureSelection::predict(const ContinuousFactor& closure) const {
  const auto x = gather(closure.keys(), closure.types(), smoother_.values());
  return predict_measurement(closure, x.data(), smoother_.joint_covariance(closure.keys()));
}

SelectionReport OnlineClosureSelection::update(const Delta& trusted,
                                               const std::vector<ContinuousFactorPtr>& closures) {
  check_names(trusted);
  return all_or_nothing([&](SelectionReport& report) { take_in(trusted, closures, report); });
}

SelectionReport OnlineClosureSelection::finish() {
  return all_or_nothing([&](SelectionReport& report) {
    report.objective_before = smoother_.objective();
    reevaluate_all(report);
    report.add(apply({}));
    report.add(taken(smoother_.converge()));
  });
}

void OnlineClosureSelection::take_in(const Delta& trusted,
                                     const std::vector<ContinuousFactorPtr>& closures,
                                     SelectionReport& report) {
  Delta delta = trusted;
  const std::size_t first = closures_.size();
  for (const ContinuousFactorPtr& factor : closures) {
    const std::size_t k = closures_.size();
    closures_.emplace_back();
    closures_.back().factor = factor;
    delta.hybrid.push_back(closure_mixture(k, factor, options_.mixture));
    delta.assignment.set(closure_switch(k).key, 1);
    set_switch(k, SwitchState::kFixedOutlier, delta);
  }
  const UpdateReport done = apply(std::move(delta));
  report.add(done);
  report.handles = done.handles;
  report.objective_before = done.objective_before;
  verdicts_.clear();
  follow(trusted);
  for (std::size_t k = first; k < closures_.size(); ++k) {
    Closure& closure = closures_[k];  // new: removed if the change fails
    closure.alone = odometry_.innovation(*closure.factor);
    closure.refuted = refuted(closure);
    if (closure.refuted) continue;
    open_.push_back(k);
    if (consider(k, report)) reconsider(report);
  }
  attempts_.attempt(kExpel, [&] { expel(report); });
  if (closures_.size() > kGrowth * evaluated_ + kFewClosures) {
    attempts_.attempt(kReevaluate, [&] { reevaluate_all(report); });
  }
}

/// Whether the odometry alone contradicts a closure.
bool OnlineClosureSelection::refuted(const Closure& closure) const {
  return closure.alone &&
         !factor_alone_.within(options_.gate, *closure.alone, closure.factor->rows(), 0.0);
}

/// The squared residual at which the mixture of a closure switches.
double OnlineClosureSelection::switch_at(std::size_t k) const {
  const MixtureOptions& mixture = options_.mixture;
  const ContinuousFactor& factor = *closures_[k].factor;
  const double outlier = mixture.null_hypothesis
                             ? *mixture.null_hypothesis - factor.log_normalizer()
                             : 0.5 * factor.rows() * std::log(mixture.outlier_variance);
  return 2.0 * (outlier + std::log(mixture.inlier_weight / mixture.outlier_weight));
}

/// Tests a closure by its innovation given the map.
bool OnlineClosureSelection::consider(std::size_t k, SelectionReport& report) {
  Closure& closure = edit(k);
  closure.innovation = predict(*closure.factor);
  return factor_.within(options_.gate, closure.innovation, closure.factor->rows(), switch_at(k)) &&
         admit(k, report);
}

/// Tests again the newest closures that may be within their gate now. Covariances only shrink, so
/// the chi-square by the last predicted one is a lower bound.
void OnlineClosureSelection::reconsider(SelectionReport& report) {
  const std::size_t first = open_.size() - std::min(open_.size(), kReconsidered);
  for (bool again = true; again;) {
    again = false;
    for (std::size_t i = first; i < open_.size(); ++i) {
      const std::size_t k = open_[i];
      const Closure& closure = closures_[k];
      if (closure.switch_state != SwitchState::kFixedOutlier || closure.failures >= kAttempts)
        continue;
      const Eigen::MatrixXd& W = closure.innovation.information;
      const auto x = gather(closure.factor->keys(), closure.factor->types(), smoother_.values());
      if (W.size() > 0 && chi_square_under(*closure.factor, x.data(), W) > switch_at(k)) continue;
      again = consider(k, report) || again;
    }
  }
}

/// Rejects closures that were accepted with a poor estimate of the noise and that contradict the
/// odometry under the present one; runs whenever the number of open closures has doubled.
void OnlineClosureSelection::expel(SelectionReport& report) {
  if (open_.size() < 2 * expelled_at_ + 5) return;
  expelled_at_ = open_.size();
  Delta delta;
  std::vector<std::size_t> stay;
  for (std::size_t k : open_) {
    const Closure& closure = closures_[k];
    if (refuted(closure)) edit(k).refuted = true;
    if (!closure.refuted) {
      stay.push_back(k);
    } else if (closure.switch_state != SwitchState::kFixedOutlier) {
      set_switch(k, SwitchState::kFixedOutlier, delta);
    }
  }
  open_ = std::move(stay);
  if (changed_switches_.empty()) return;
  report.add(apply(std::move(delta)));
  for (std::size_t k : open_) edit(k).failures = 0;
  reconsider(report);
}

void OnlineClosureSelection::free(std::size_t k) {
  Closure& closure = edit(k);
  if (closure.table.valid()) lifted_.push_back(closure.table);
  closure.table = {};
  closure.switch_state = SwitchState::kFree;
}

/// Admits a closure if that lowers the objective and does not make the system singular.
bool OnlineClosureSelection::admit(std::size_t k, SelectionReport& report) {
  ++report.tried;
  bool better = false;
  attempts_.attempt({k, 0}, [&] { better = is_better_with(k, report); });
  Closure& closure = edit(k);
  closure.failures = better ? 0 : closure.failures + 1;
  if (!better) return false;
  factor_.add(closure.innovation, closure.factor->rows());
  if (closure.alone) factor_alone_.add(*closure.alone, closure.factor->rows());
  ++report.admitted;
  return true;
}

/// Fixes a closure as an inlier for some updates. Frees its switch if the joint objective falls,
/// else withdraws it.
bool OnlineClosureSelection::is_better_with(std::size_t k, SelectionReport& report) {
  const double before = smoother_.objective();
  const IncrementalSmoother::Snapshot estimate = smoother_.snapshot();
  std::vector<bool> accepted_before(closures_.size());
  for (std::size_t i = 0; i < closures_.size(); ++i) accepted_before[i] = accepted(i);
  Delta delta;
  set_switch(k, SwitchState::kFixedInlier, delta);
  report.add(apply(std::move(delta)));
  double left = smoother_.objective() - before;
  for (int i = 1; i < kSettle && left >= 0.0; ++i) {
    report.add(apply({}));
    const double now = smoother_.objective() - before;
    if (now > kProgress * left) break;
    left = now;
  }
  const bool better = smoother_.objective() < before;
  better ? free(k) : withdraw(k, accepted_before, estimate);
  return better;
}

/// Undoes an attempt: the estimate and all switches are as before.
void OnlineClosureSelection::withdraw(std::size_t k, const std::vector<bool>& before,
                                      const IncrementalSmoother::Snapshot& estimate) {
  std::vector<std::size_t> moved;
  Delta delta;
  set_switch(k, SwitchState::kFixedOutlier, delta);
  while (!changed_switches_.empty()) {
    apply(std::exchange(delta, {}));
    for (std::size_t i = 0; i < closures_.size(); ++i) {
      if (closures_[i].switch_state != SwitchState::kFree || accepted(i) == before[i]) continue;
      set_switch(i, before[i] ? SwitchState::kFixedInlier : SwitchState::kFixedOutlier, delta);
      moved.push_back(i);
    }
  }
  taken(smoother_.restore(estimate));
  for (std::size_t i : moved) free(i);
}

ClosureStatus OnlineClosureSelection::status(std::size_t closure) const {
  if (accepted(closure)) return ClosureStatus::kAccepted;
  return closures_[closure].refuted ? ClosureStatus::kRejectedByOdometry
                                    : ClosureStatus::kUndecided;
}

std::vector<Verdict> OnlineClosureSelection::verdicts() const {
  if (verdicts_.size() == closures_.size()) {
    std::vector<Verdict> verdicts = verdicts_;
    for (std::size_t k = 0; k < verdicts.size(); ++k) verdicts[k].accepted = accepted(k);
    return verdicts;
  }
  RobustProblem problem;
  std::vector<bool> in;
  for (std::size_t k = 0; k < closures_.size(); ++k) {
    problem.closures.push_back(closures_[k].factor);
    in.push_back(accepted(k));
  }
  std::vector<Verdict> verdicts = make_verdicts(problem, smoother_.values(), in, options_.mixture);
  for (std::size_t k = 0; k < closures_.size(); ++k) {
    if (closures_[k].refuted) continue;
    const ContinuousFactor& factor = *closures_[k].factor;
    const auto x = gather(factor.keys(), factor.types(), smoother_.values());
    const Eigen::MatrixXd P = smoother_.joint_covariance(factor.keys());
    verdicts[k].redundancy = in[k] ? joined_redundancy(factor, x.data(), P)
                                   : predict_measurement(factor, x.data(), P).redundancy;
    verdicts[k].checkable = verdicts[k].redundancy >= options_.min_redundancy;
  }
  return verdicts;
}

}  // namespace hybrid
