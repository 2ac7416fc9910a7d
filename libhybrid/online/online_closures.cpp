// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, the hybrid mapping authors
// Tests of single closures by the online selection.
#include <Eigen/Cholesky>
#include <algorithm>
#include <cmath>
#include <map>
#include <utility>

#include "libhybrid/core/paced_task.h"
#include "libhybrid/online/online_selection.h"
#include "libhybrid/selection/detail/evidence.h"
#include "libhybrid/selection/detail/innovation.h"
#include "libhybrid/smoother/transaction.h"

namespace hybrid {
namespace {

/// Updates within which an admitted closure must lower the objective.
constexpr int kSettle = 6;
/// An attempt ends when an update leaves more than this share of the rise of the objective.
constexpr double kProgress = 0.8;
/// The radius of the map is measured again when it has grown by this factor.
constexpr double kMapGrowth = 1.1;
/// Earlier closures that one update tests again, the newest: a budget of its time.
constexpr std::size_t kMostTestedAgain = 40;

}  // namespace

bool OnlineSelection::accepted(std::size_t k) const {
  return smoother_.assignment().at(closure_switch(k).key) == 0;
}

/// The model by which closures are tested: that of the last evaluation of all, on the present map.
EvidenceModel OnlineSelection::evidence_model() const {
  return {options_.selection.degrees_of_freedom, variance_factor_, options_.selection.gate,
          radius_};
}

double OnlineSelection::threshold() const {
  return evidence_needed(out_, options_.selection);
}

/// Measures the radius of the map anew when it has grown.
void OnlineSelection::measure_map() {
  const std::size_t size = smoother_.values().size();
  if (static_cast<double>(size) < kMapGrowth * static_cast<double>(measured_at_)) return;
  radius_ = map_radius(smoother_.values());
  measured_at_ = size;
}

/// Tests a new closure, or keeps it back for the choices that it spans.
void OnlineSelection::ask(std::size_t k, SelectionReport& report) {
  const ContinuousFactorPtr& factor = closures_[k].factor;
  if (choices_.are_open_between(factor->keys().front(), factor->keys().back())) {
    if (!choices_.keep({factor, k}, smoother_)) edit(k).decision.evidence = -kInfinity;
    return;
  }
  if (consider(k, report)) open_ = reconsider(report);
}

/// The squared residual at which the mixture of a closure switches.
double OnlineSelection::switch_at(std::size_t k) const {
  const MixtureOptions& mixture = options_.mixture;
  const ContinuousFactor& factor = *closures_[k].factor;
  const double outlier = mixture.null_hypothesis
                             ? *mixture.null_hypothesis - factor.log_normalizer()
                             : 0.5 * factor.rows() * std::log(mixture.outlier_variance);
  return 2.0 * (outlier + std::log(mixture.inlier_weight / mixture.outlier_weight));
}

/// Adds the true ones of closures that have waited to the smoother, and tests the others.
void OnlineSelection::let_in(const std::vector<WaitingClosure>& closures, SelectionReport& report) {
  Delta delta;
  for (const WaitingClosure& closure : closures) {
    if (!closure.number) delta.continuous.push_back(closure.factor);
  }
  choices_.expect(delta.continuous);
  if (!delta.continuous.empty()) report.add(taken(smoother_.update(delta)));
  bool admitted = false;
  for (const WaitingClosure& closure : closures) {
    if (!closure.number) continue;
    admitted = consider(*closure.number, report) || admitted;
  }
  if (admitted) open_ = reconsider(report);
}

bool OnlineSelection::may_be_tried(const Closure& closure) const {
  return closure.switch_state == SwitchState::kFixedOutlier && !closure.failed;
}

/// Tests a closure that is out by its evidence given the map. Over open choices, the map says
/// nothing.
bool OnlineSelection::consider(std::size_t k, SelectionReport& report) {
  if (!may_be_tried(closures_[k])) return false;
  if (alternatives_.exclude(k, [this](std::size_t i) { return accepted(i); })) return false;
  Closure& closure = edit(k);
  const ContinuousFactor& factor = *closure.factor;
  if (choices_.are_open_between(factor.keys().front(), factor.keys().back())) return false;
  const GivenOthers alone = given_others(innovation_of(factor), false);
  closure.predicted = alone.S;
  closure.decision.evidence = evidence_model().log_ratio(alone.b, alone.S, factor);
  // To first order, the objective rises by half the chi-square of the innovation.
  const double chi_square = alone.S.llt().matrixL().solve(alone.b).squaredNorm();
  return closure.decision.evidence > threshold() && chi_square < switch_at(k) && stands_out(k) &&
         admit(k, report);
}

/// Whether the evidence for a closure is enough against alternatives to it, too.
bool OnlineSelection::stands_out(std::size_t k) const {
  if (alternatives_.set_of(k).empty()) return true;
  std::vector<double> evidence(closures_.size(), 0.0);
  for (const std::size_t i : alternatives_.set_of(k)) {
    const ContinuousFactor& factor = *closures_[i].factor;
    const GivenOthers alone = given_others(innovation_of(factor), false);
    evidence[i] = evidence_model().log_ratio(alone.b, alone.S, factor);
  }
  return against_alternatives(k, evidence, alternatives_) > threshold();
}

/// The residual of a closure and its covariance by the map.
Innovation OnlineSelection::innovation_of(const ContinuousFactor& factor) const {
  const auto x = gather(factor.keys(), factor.types(), smoother_.values());
  Innovation innovation{Eigen::VectorXd(factor.rows()), {}};
  Eigen::MatrixXd A(factor.rows(), factor.cols());
  factor.linearize(x.data(), innovation.b.data(), A.data());
  innovation.APAt = A * smoother_.joint_covariance(factor.keys()) * A.transpose();
  return innovation;
}

/// The same of a closure as if no alternative to it were accepted.
Innovation OnlineSelection::innovation_against(std::size_t k) const {
  const ContinuousFactor& factor = *closures_[k].factor;
  Innovation innovation = innovation_of(factor);
  if (accepted(k)) return innovation;
  for (const std::size_t other : alternatives_.set_of(k)) {
    if (other == k || !accepted(other)) continue;
    const ContinuousFactor& part = *closures_[other].factor;
    innovation = without(innovation, innovation_of(part), cross_covariance(factor, part));
  }
  return innovation;
}

/// A P B' of two factors.
Eigen::MatrixXd OnlineSelection::cross_covariance(const ContinuousFactor& a,
                                                  const ContinuousFactor& b) const {
  std::vector<Key> keys = a.keys();
  for (Key key : b.keys()) {
    if (std::find(keys.begin(), keys.end(), key) == keys.end()) keys.push_back(key);
  }
  std::map<Key, int> column;
  int columns = 0;
  for (Key key : keys) {
    column[key] = columns;
    columns += smoother_.values().type(key).dim;
  }
  const auto spread = [&](const ContinuousFactor& factor) {
    const auto x = gather(factor.keys(), factor.types(), smoother_.values());
    Eigen::VectorXd r(factor.rows());
    Eigen::MatrixXd A(factor.rows(), factor.cols());
    factor.linearize(x.data(), r.data(), A.data());
    Eigen::MatrixXd J = Eigen::MatrixXd::Zero(factor.rows(), columns);
    int at = 0;
    for (Key key : factor.keys()) {
      const int dim = smoother_.values().type(key).dim;
      J.middleCols(column[key], dim) = A.middleCols(at, dim);
      at += dim;
    }
    return J;
  };
  return spread(a) * smoother_.joint_covariance(keys) * spread(b).transpose();
}

/// Whether the update under way has done as much as one may.
bool OnlineSelection::is_long() const {
  return (noted_work() - work_before_) * updates_ > options_.spread * work_;
}

/// Tests again the newest closures that have enough evidence now under the covariance last
/// predicted, and those without one. Returns whether there are more for later updates to test.
bool OnlineSelection::reconsider(SelectionReport& report) {
  std::vector<std::size_t> newest;
  for (std::size_t k = closures_.size(); k-- > 0 && newest.size() < kMostTestedAgain;) {
    if (may_be_tried(closures_[k])) newest.push_back(k);
  }
  std::reverse(newest.begin(), newest.end());
  for (bool again = true; again;) {
    again = false;
    for (const std::size_t k : newest) {
      const Closure& closure = closures_[k];
      if (!may_be_tried(closure)) continue;
      if (is_long()) return true;
      if (closure.predicted.size() > 0) {
        const ContinuousFactor& factor = *closure.factor;
        const auto x = gather(factor.keys(), factor.types(), smoother_.values());
        Eigen::VectorXd b(factor.rows());
        Eigen::MatrixXd A(factor.rows(), factor.cols());
        factor.linearize(x.data(), b.data(), A.data());
        if (evidence_model().log_ratio(b, closure.predicted, factor) <= threshold()) continue;
      }
      again = consider(k, report) || again;
    }
  }
  return false;
}

void OnlineSelection::free(std::size_t k) {
  Closure& closure = edit(k);
  if (closure.table.valid()) lifted_.push_back(closure.table);
  closure.table = {};
  out_ -= closure.switch_state == SwitchState::kFixedOutlier ? 1 : 0;
  closure.switch_state = SwitchState::kFree;
}

/// Admits a closure if that lowers the objective and does not make the system singular.
bool OnlineSelection::admit(std::size_t k, SelectionReport& report) {
  ++report.tried;
  const Closure before = edit(k);
  const std::vector<Handle> lifted = lifted_;
  const std::size_t out = out_;
  if (attempt(smoother_, [&] { return is_better_with(k, report); })) {
    closures_[k].failed = false;
    ++report.admitted;
    return true;
  }
  closures_[k] = before;
  closures_[k].failed = true;
  lifted_ = lifted;
  out_ = out;
  changed_switches_.clear();
  return false;
}

/// Fixes a closure as an inlier for some updates, and frees its switch if the joint objective
/// falls.
bool OnlineSelection::is_better_with(std::size_t k, SelectionReport& report) {
  const double before = smoother_.objective();
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
  if (!(smoother_.objective() < before)) return false;
  free(k);
  return true;
}

}  // namespace hybrid
