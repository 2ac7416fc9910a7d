// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, the hybrid mapping authors
// Evaluation of all closures by the online selection.
#include <algorithm>
#include <cmath>
#include <utility>

#include "libhybrid/core/key_letters.h"
#include "libhybrid/selection/detail/evidence.h"
#include "libhybrid/selection/online_selection.h"

namespace hybrid {
/// The robust problem of all factors so far, with the components of trusted hybrid factors that an
/// assignment chooses.
RobustProblem OnlineSelection::problem(const Assignment& assignment) const {
  RobustProblem problem;
  problem.initial = smoother_.values();
  smoother_.graph().continuous().for_each(
      [&](Handle, const ContinuousFactorPtr& factor) { problem.trusted.push_back(factor); });
  smoother_.graph().hybrid().for_each([&](Handle, const HybridFactorPtr& factor) {
    if (factor->discrete_keys()[0].key.letter() == key_letter::kClosureSwitch) return;
    const Component component = factor->given(assignment);
    if (component.factor != nullptr) problem.trusted.emplace_back(factor, component.factor);
  });
  for (const Closure& closure : closures_) problem.closures.push_back(closure.factor);
  problem.alternatives = alternatives_;
  return problem;
}

/// The variance factor, at most one, of the accepted closures of a result.
double OnlineSelection::noise(const Values& values, const std::vector<bool>& in) const {
  std::vector<double> chi_squares;
  std::vector<int> rows;
  for (std::size_t k = 0; k < in.size(); ++k) {
    if (!in[k]) continue;
    chi_squares.push_back(2.0 * closures_[k].factor->cost(values));
    rows.push_back(closures_[k].factor->rows());
  }
  return std::min(1.0, variance_factor(chi_squares, rows));
}

/// Evaluates all closures from scratch; or from the present map, if the last evaluation from
/// scratch is recent, or if the accepted closures have far less noise in the present map: the
/// evaluation from scratch has then accepted false closures within overstated noise.
void OnlineSelection::reevaluate_all(SelectionReport& report) {
  RobustProblem problem = this->problem(smoother_.assignment());
  ClosureSelectionOptions present = options_.selection;
  present.trust_start = true;
  RobustResult best;
  if (closures_.size() > evaluated_) {
    best = select_closures(problem, options_.selection);
    evaluated_ = closures_.size();
    std::vector<bool> now, then;
    for (std::size_t k = 0; k < closures_.size(); ++k) {
      now.push_back(accepted(k));
      then.push_back(best.decisions[k].accepted());
    }
    if (options_.selection.gate * noise(smoother_.values(), now) < noise(best.values, then)) {
      best = select_closures(problem, present);
    }
  } else {
    best = select_closures(problem, present);
  }
  adopt(best, report);
  revise_by_closures(best, report);
  variance_factor_ = best.variance_factor;
  for (std::size_t k = 0; k < closures_.size(); ++k) edit(k).decision = best.decisions[k];
  judged_ = true;
}

/// Adopts the decisions and values of a result of select_closures.
void OnlineSelection::adopt(const RobustResult& result, SelectionReport& report) {
  Delta delta;
  std::vector<std::size_t> in;
  for (std::size_t k = 0; k < closures_.size(); ++k) {
    Closure& closure = edit(k);
    const bool accept = result.decisions[k].accepted();
    if (accept) in.push_back(k);
    if (closure.switch_state == (accept ? SwitchState::kFixedInlier : SwitchState::kFixedOutlier))
      continue;
    if (accept && !accepted(k)) ++report.admitted;
    set_switch(k, accept ? SwitchState::kFixedInlier : SwitchState::kFixedOutlier, delta);
  }
  report.add(apply(std::move(delta)));
  IncrementalSmoother::Snapshot estimate{smoother_.values().keys(), {}};
  for (Key key : estimate.keys) {
    const double* x = result.values.data(key);
    estimate.numbers.insert(estimate.numbers.end(), x, x + result.values.type(key).size);
  }
  taken(smoother_.restore(estimate));
  for (std::size_t k : in) {
    if (2.0 * closures_[k].factor->cost(smoother_.values()) < switch_at(k)) free(k);
  }
  for (std::size_t k = 0; k < closures_.size(); ++k) {
    Closure& closure = edit(k);
    closure.failed = false;
    closure.predicted.resize(0, 0);  // covariances may have grown
  }
}

}  // namespace hybrid
