// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, the hybrid mapping authors
#include "libhybrid/robust/online_judge.h"

#include <algorithm>
#include <chrono>
#include <cmath>
#include <limits>
#include <utility>

#include "libhybrid/core/chi_square.h"
#include "libhybrid/core/elapsed.h"

namespace hybrid {
namespace {

/// Updates that an admitted closure has to bring the objective down.
constexpr int kSettle = 6;
/// Attempts after which a single closure is only tried together with others.
constexpr int kAttempts = 3;
constexpr int kFinalRounds = 3;
/// Newest closures that another is compared with.
constexpr std::size_t kCompared = 300;
constexpr double kInfinity = std::numeric_limits<double>::infinity();

using Clock = std::chrono::steady_clock;

bool is_pose(VariableType type) {
  return type.kind == VariableKind::kSE2 || type.kind == VariableKind::kSE3;
}

void merge(const UpdateReport& update, JudgeReport& report) {
  report.status = update.status;
  if (!update.message.empty()) report.message = update.message;
  report.relinearized += update.relinearized;
  report.eliminated += update.eliminated;
  report.cliques += update.cliques;
  report.flips += update.flips;
  report.components += update.components;
  report.rounds += update.rounds;
  report.exact = report.exact && update.exact;
}

}  // namespace

OnlineJudge::OnlineJudge(const OnlineJudgeOptions& options)
    : options_(options), smoother_(options.smoother) {}

/// Keeps the path of odometry up to date: a new pose hangs on its first trusted factor with an
/// earlier one.
void OnlineJudge::follow(const Delta& trusted) {
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

/// Forbids one value of the switch of a closure by a table, or lets it free.
void OnlineJudge::set_hold(std::size_t k, Hold hold, Delta& delta) {
  Closure& closure = closures_[k];
  if (closure.table.valid()) delta.remove.push_back(closure.table);
  closure.table = {};
  closure.hold = hold;
  if (hold == Hold::kFree) return;
  delta.discrete.emplace_back(std::vector<DiscreteKey>{closure_switch(k)},
                              hold == Hold::kIn ? std::vector<double>{0.0, kInfinity}
                                                : std::vector<double>{kInfinity, 0.0});
  changed_holds_.push_back(k);
}

UpdateReport OnlineJudge::apply(Delta delta) {
  delta.remove.insert(delta.remove.end(), lifted_.begin(), lifted_.end());
  const UpdateReport report = smoother_.update(delta);
  if (report.status != UpdateReport::Status::kOk) return report;
  lifted_.clear();
  const std::size_t first = delta.continuous.size() + delta.discrete.size() - changed_holds_.size();
  for (std::size_t i = 0; i < changed_holds_.size(); ++i) {
    closures_[changed_holds_[i]].table = report.handles[first + i];
  }
  changed_holds_.clear();
  return report;
}

bool OnlineJudge::accepted(std::size_t k) const {
  return smoother_.assignment().at(closure_switch(k).key) == 0;
}

Prediction OnlineJudge::predict(const ContinuousFactor& closure) const {
  const auto x = gather(closure.keys(), closure.types(), smoother_.values());
  return predict_measurement(closure, x.data(), smoother_.joint_covariance(closure.keys()));
}

JudgeReport OnlineJudge::update(const Delta& trusted,
                                const std::vector<ContinuousFactorPtr>& closures) {
  const auto start = Clock::now();
  JudgeReport report;
  Delta delta = trusted;
  const std::size_t first = closures_.size();
  for (const ContinuousFactorPtr& factor : closures) {
    const std::size_t k = closures_.size();
    closures_.emplace_back();
    closures_.back().factor = factor;
    delta.hybrid.push_back(closure_mixture(k, factor, options_.mixture));
    delta.assignment.set(closure_switch(k).key, 1);
    set_hold(k, Hold::kOut, delta);
  }
  const UpdateReport done = [&] {
    try {
      return apply(std::move(delta));
    } catch (...) {
      closures_.resize(first);
      changed_holds_.clear();
      throw;
    }
  }();
  merge(done, report);
  report.handles = done.handles;
  report.objective_before = done.objective_before;
  if (done.status != UpdateReport::Status::kOk) {
    closures_.resize(first);
    changed_holds_.clear();
    return report;
  }
  follow(trusted);
  for (std::size_t k = first; k < closures_.size(); ++k) {
    Closure& closure = closures_[k];
    closure.alone = odometry_.innovation(*closure.factor);
    closure.refuted = refuted(closure);
    if (closure.refuted) continue;
    open_.push_back(k);
    if (consider(k, report)) {
      reconsider(report);
    } else {
      challenge(k, report);
    }
  }
  expel(report);
  report.objective_after = smoother_.objective();
  report.seconds = seconds_since(start);
  return report;
}

/// Whether the odometry alone contradicts a closure.
bool OnlineJudge::refuted(const Closure& closure) const {
  return closure.alone &&
         !factor_alone_.within(options_.gate, *closure.alone, closure.factor->rows(), 0.0);
}

/// The squared residual at which the mixture of a closure switches.
double OnlineJudge::switch_at(std::size_t k) const {
  const MixtureOptions& mixture = options_.mixture;
  const ContinuousFactor& factor = *closures_[k].factor;
  const double outlier = mixture.null_hypothesis
                             ? *mixture.null_hypothesis - factor.log_normalizer()
                             : 0.5 * factor.rows() * std::log(mixture.outlier_variance);
  return 2.0 * (outlier + std::log(mixture.inlier_weight / mixture.outlier_weight));
}

/// Judges a closure by its innovation given the map.
bool OnlineJudge::consider(std::size_t k, JudgeReport& report) {
  Closure& closure = closures_[k];
  closure.innovation = predict(*closure.factor);
  return factor_.within(options_.gate, closure.innovation, closure.factor->rows(), switch_at(k)) &&
         admit({k}, {}, report);
}

/// Judges again those closures that may have come within their gate: covariances only shrink, so
/// the last one predicted bounds what a new one can allow.
void OnlineJudge::reconsider(JudgeReport& report) {
  for (bool again = true; again;) {
    again = false;
    for (std::size_t k : open_) {
      Closure& closure = closures_[k];
      if (closure.hold != Hold::kOut || closure.failures >= kAttempts) continue;
      const auto x = gather(closure.factor->keys(), closure.factor->types(), smoother_.values());
      const double bound =
          chi_square_under(*closure.factor, x.data(), closure.innovation.information);
      if (bound > switch_at(k)) continue;
      again = consider(k, report) || again;
    }
  }
}

/// Tries a closure together with all others that are out and agree with it along the cycle that two
/// closures make with the odometry, against those accepted that do not agree.
void OnlineJudge::challenge(std::size_t k, JudgeReport& report) {
  std::vector<std::size_t> group = {k};
  std::vector<std::size_t> against;
  const std::size_t compared = std::min(open_.size(), kCompared);
  for (std::size_t i = open_.size() - compared; i < open_.size(); ++i) {
    const std::size_t other = open_[i];
    if (other == k) continue;
    const ContinuousFactor& factor = *closures_[k].factor;
    const auto given = odometry_.innovation_given(*closures_[other].factor, factor);
    if (!given) continue;
    const bool agrees = factor_.within(options_.gate, *given, factor.rows(), switch_at(k));
    const bool in = accepted(other);
    if (agrees && !in) group.push_back(other);
    if (!agrees && in) against.push_back(other);
  }
  std::size_t failed = std::max<std::size_t>(1, against.size());
  for (std::size_t member : group) failed = std::max(failed, closures_[member].crowd);
  if (group.size() <= failed || admit(group, against, report)) return;
  for (std::size_t member : group) closures_[member].crowd = 2 * group.size();
}

/// Throws out what was accepted while little was known of the noise and is too far from the
/// odometry now that more is; looked for whenever the number of closures has doubled.
void OnlineJudge::expel(JudgeReport& report) {
  if (open_.size() < 2 * expelled_at_ + 5) return;
  expelled_at_ = open_.size();
  Delta delta;
  std::vector<std::size_t> stay;
  for (std::size_t k : open_) {
    Closure& closure = closures_[k];
    closure.refuted = refuted(closure);
    if (!closure.refuted) {
      stay.push_back(k);
    } else if (closure.hold != Hold::kOut) {
      set_hold(k, Hold::kOut, delta);
    }
  }
  open_ = std::move(stay);
  if (changed_holds_.empty()) return;
  merge(apply(std::move(delta)), report);
  for (std::size_t k : open_) closures_[k].failures = 0;
  reconsider(report);
}

void OnlineJudge::free(std::size_t k) {
  if (closures_[k].table.valid()) lifted_.push_back(closures_[k].table);
  closures_[k].table = {};
  closures_[k].hold = Hold::kFree;
}

/// Holds closures in their inlier mode, and others in their outlier mode, until the map has taken
/// that in, and keeps it so where the joint objective has fallen.
bool OnlineJudge::admit(const std::vector<std::size_t>& group,
                        const std::vector<std::size_t>& against, JudgeReport& report) {
  ++report.tried;
  const double before = smoother_.objective();
  const std::vector<double> estimate = smoother_.snapshot();
  std::vector<bool> standing(closures_.size());
  for (std::size_t k = 0; k < closures_.size(); ++k) standing[k] = accepted(k);
  Delta delta;
  for (std::size_t k : group) set_hold(k, Hold::kIn, delta);
  for (std::size_t k : against) set_hold(k, Hold::kOut, delta);
  merge(apply(std::move(delta)), report);
  // Among many, some that agree with the newest need not agree with the others: once the map has
  // moved, each is free to leave.
  for (int i = 1; i < kSettle && !(smoother_.objective() < before); ++i) {
    if (i == kSettle / 2 && group.size() > 1) {
      for (std::size_t k : group) free(k);
    }
    merge(apply({}), report);
  }
  if (!(smoother_.objective() < before)) {
    std::vector<std::size_t> tried = group;
    tried.insert(tried.end(), against.begin(), against.end());
    withdraw(tried, standing, estimate);
    for (std::size_t k : group) ++closures_[k].failures;
    return false;
  }
  for (std::size_t k : group) {
    Closure& closure = closures_[k];
    free(k);
    closure.failures = 0;
    if (group.size() == 1) factor_.add(closure.innovation, closure.factor->rows());
    if (closure.alone) factor_alone_.add(*closure.alone, closure.factor->rows());
  }
  report.admitted += static_cast<int>(group.size());
  return true;
}

/// Takes an attempt back: all goes where it stood.
void OnlineJudge::withdraw(const std::vector<std::size_t>& tried, const std::vector<bool>& before,
                           const std::vector<double>& estimate) {
  std::vector<std::size_t> moved = tried;
  Delta delta;
  for (std::size_t k : tried) set_hold(k, before[k] ? Hold::kIn : Hold::kOut, delta);
  for (bool again = true; again;) {
    for (std::size_t k = 0; k < closures_.size(); ++k) {
      if (closures_[k].hold != Hold::kFree || accepted(k) == before[k]) continue;
      set_hold(k, before[k] ? Hold::kIn : Hold::kOut, delta);
      moved.push_back(k);
    }
    again = !changed_holds_.empty();
    if (again) apply(std::exchange(delta, {}));
  }
  smoother_.restore(estimate);
  for (std::size_t k : tried) {
    if (closures_[k].hold == Hold::kIn) free(k);
  }
  for (std::size_t i = tried.size(); i < moved.size(); ++i) free(moved[i]);
}

/// Asks again for all closures whether the odometry contradicts them, with what is known of the
/// noise by now.
void OnlineJudge::reopen() {
  for (std::size_t k = 0; k < closures_.size(); ++k) {
    Closure& closure = closures_[k];
    if (!closure.refuted || refuted(closure)) continue;
    closure.refuted = false;
    closure.innovation = predict(*closure.factor);
    open_.push_back(k);
  }
  std::sort(open_.begin(), open_.end());
}

JudgeReport OnlineJudge::finish() {
  const auto start = Clock::now();
  JudgeReport report;
  report.objective_before = smoother_.objective();
  reopen();
  expelled_at_ = 0;
  expel(report);
  for (int round = 0; round < kFinalRounds; ++round) {
    if (!lifted_.empty()) merge(apply({}), report);
    merge(smoother_.converge(), report);
    const int admitted = report.admitted;
    for (std::size_t k : open_) closures_[k].failures = 0;
    reconsider(report);
    for (std::size_t k : std::vector<std::size_t>(open_)) {
      if (closures_[k].hold == Hold::kOut) challenge(k, report);
    }
    if (report.admitted == admitted) break;
  }
  report.objective_after = smoother_.objective();
  report.seconds = seconds_since(start);
  return report;
}

Standing OnlineJudge::standing(std::size_t closure) const {
  if (accepted(closure)) return Standing::kAccepted;
  return closures_[closure].refuted ? Standing::kRefuted : Standing::kUndecided;
}

std::vector<Verdict> OnlineJudge::verdicts() const {
  RobustProblem problem;
  std::vector<bool> in;
  for (std::size_t k = 0; k < closures_.size(); ++k) {
    problem.closures.push_back(closures_[k].factor);
    in.push_back(accepted(k));
  }
  std::vector<Verdict> verdicts = judge(problem, smoother_.values(), in, options_.mixture);
  for (std::size_t k = 0; k < closures_.size(); ++k) {
    if (closures_[k].refuted) continue;
    const ContinuousFactor& factor = *closures_[k].factor;
    const auto x = gather(factor.keys(), factor.types(), smoother_.values());
    const Eigen::MatrixXd P = smoother_.joint_covariance(factor.keys());
    verdicts[k].redundancy = in[k] ? joined_redundancy(factor, x.data(), P)
                                   : predict_measurement(factor, x.data(), P).redundancy;
    verdicts[k].checkable = verdicts[k].redundancy >= options_.checkable;
  }
  return verdicts;
}

}  // namespace hybrid
