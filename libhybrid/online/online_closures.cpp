// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, the hybrid mapping authors
// Tests of single closures by the online selection.
#include <Eigen/Cholesky>
#include <algorithm>
#include <cmath>
#include <map>
#include <utility>
#include <vector>

#include "libhybrid/core/infinity.h"
#include "libhybrid/core/paced_task.h"
#include "libhybrid/factors/linear_at.h"
#include "libhybrid/online/online_selection.h"
#include "libhybrid/selection/evidence.h"
#include "libhybrid/selection/innovation.h"
#include "libhybrid/smoother/incremental.h"
#include "libhybrid/smoother/transaction.h"

namespace hybrid {
namespace {

/// The residual of a factor that is not in a map, and its covariance by the map.
Innovation innovation_of(const ContinuousFactor& factor, const IncrementalSmoother& smoother) {
  const ResidualAndJacobian at = linear_at(factor, smoother.values());
  return {at.r, at.J * smoother.joint_covariance(factor.keys()) * at.J.transpose()};
}

/// A P B' of two factors with the Jacobians A and B, and P the covariance of the map.
Eigen::MatrixXd cross_covariance(const ContinuousFactor& a, const ContinuousFactor& b,
                                 const IncrementalSmoother& smoother) {
  std::vector<Key> keys = a.keys();
  for (Key key : b.keys()) {
    if (std::find(keys.begin(), keys.end(), key) == keys.end()) keys.push_back(key);
  }
  std::map<Key, int> column;
  int columns = 0;
  for (Key key : keys) {
    column[key] = columns;
    columns += smoother.values().type(key).dim;
  }
  const auto spread = [&](const ContinuousFactor& factor) {
    const Eigen::MatrixXd A = linear_at(factor, smoother.values()).J;
    Eigen::MatrixXd J = Eigen::MatrixXd::Zero(factor.rows(), columns);
    int at = 0;
    for (Key key : factor.keys()) {
      const int dim = smoother.values().type(key).dim;
      J.middleCols(column[key], dim) = A.middleCols(at, dim);
      at += dim;
    }
    return J;
  };
  return spread(a) * smoother.joint_covariance(keys) * spread(b).transpose();
}

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
  return evidence_needed(closures_.out(), options_.selection);
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
    if (!choices_.keep({factor, k}, smoother_)) closures_.edit(k).decision.evidence = -kInfinity;
    return;
  }
  if (consider(k, report)) open_ = reconsider(report);
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

/// Tests a closure that is out by its evidence given the map. Over open choices, the map says
/// nothing.
bool OnlineSelection::consider(std::size_t k, SelectionReport& report) {
  if (!closures_.may_be_tried(k)) return false;
  if (closures_.alternatives().exclude(k, [this](std::size_t i) { return accepted(i); }))
    return false;
  SwitchedClosures::Closure& closure = closures_.edit(k);
  const ContinuousFactor& factor = *closure.factor;
  if (choices_.are_open_between(factor.keys().front(), factor.keys().back())) return false;
  const GivenOthers alone = given_others(innovation_of(factor, smoother_), false);
  closure.predicted = alone.S;
  closure.decision.evidence = evidence_model().log_ratio(alone.b, alone.S, factor);
  // To first order, the objective rises by half the chi-square of the innovation.
  const double chi_square = alone.S.llt().matrixL().solve(alone.b).squaredNorm();
  return closure.decision.evidence > threshold() && chi_square < closures_.switch_at(k) &&
         stands_out(k) && admit(k, report);
}

/// Whether the evidence for a closure is enough against alternatives to it, too.
bool OnlineSelection::stands_out(std::size_t k) const {
  if (closures_.alternatives().set_of(k).empty()) return true;
  std::vector<double> evidence(closures_.size(), 0.0);
  for (const std::size_t i : closures_.alternatives().set_of(k)) {
    const ContinuousFactor& factor = *closures_[i].factor;
    const GivenOthers alone = given_others(innovation_of(factor, smoother_), false);
    evidence[i] = evidence_model().log_ratio(alone.b, alone.S, factor);
  }
  return against_alternatives(k, evidence, closures_.alternatives()) > threshold();
}

/// The same of a closure as if no alternative to it were accepted.
Innovation OnlineSelection::innovation_against(std::size_t k) const {
  const ContinuousFactor& factor = *closures_[k].factor;
  Innovation innovation = innovation_of(factor, smoother_);
  if (accepted(k)) return innovation;
  for (const std::size_t other : closures_.alternatives().set_of(k)) {
    if (other == k || !accepted(other)) continue;
    const ContinuousFactor& part = *closures_[other].factor;
    innovation = without(innovation, innovation_of(part, smoother_),
                         cross_covariance(factor, part, smoother_));
  }
  return innovation;
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
    if (closures_.may_be_tried(k)) newest.push_back(k);
  }
  std::reverse(newest.begin(), newest.end());
  for (bool again = true; again;) {
    again = false;
    for (const std::size_t k : newest) {
      const SwitchedClosures::Closure& closure = closures_[k];
      if (!closures_.may_be_tried(k)) continue;
      if (is_long()) return true;
      if (closure.predicted.size() > 0) {
        const ContinuousFactor& factor = *closure.factor;
        const Eigen::VectorXd b = linear_at(factor, smoother_.values()).r;
        if (evidence_model().log_ratio(b, closure.predicted, factor) <= threshold()) continue;
      }
      again = consider(k, report) || again;
    }
  }
  return false;
}

/// Admits a closure if that lowers the objective and does not make the system singular.
bool OnlineSelection::admit(std::size_t k, SelectionReport& report) {
  ++report.tried;
  SwitchedClosures::Before before = closures_.before(k);
  const bool is_in = attempt(smoother_, [&] { return is_better_with(k, report); });
  if (!is_in) closures_.take_back(std::move(before));
  closures_.edit(k).failed = !is_in;
  report.admitted += is_in ? 1 : 0;
  return is_in;
}

/// Fixes a closure as an inlier for some updates, and frees its switch if the joint objective
/// falls.
bool OnlineSelection::is_better_with(std::size_t k, SelectionReport& report) {
  const double before = smoother_.objective();
  Delta delta;
  closures_.set_switch(k, SwitchedClosures::SwitchState::kFixedInlier, delta);
  report.add(closures_.apply(std::move(delta), smoother_));
  double left = smoother_.objective() - before;
  for (int i = 1; i < kSettle && left >= 0.0; ++i) {
    report.add(closures_.apply({}, smoother_));
    const double now = smoother_.objective() - before;
    if (now > kProgress * left) break;
    left = now;
  }
  if (!(smoother_.objective() < before)) return false;
  closures_.free(k);
  return true;
}

}  // namespace hybrid
