// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, the hybrid mapping authors
#include "libhybrid/online/switched_closures.h"

#include <cmath>
#include <utility>

#include "libhybrid/core/infinity.h"
#include "libhybrid/smoother/transaction.h"

namespace hybrid {

double SwitchedClosures::switch_at(std::size_t k) const {
  const ContinuousFactor& factor = *closures_[k].factor;
  const double outlier = mixture_.null_hypothesis
                             ? *mixture_.null_hypothesis - factor.log_normalizer()
                             : 0.5 * factor.rows() * std::log(mixture_.outlier_variance);
  return 2.0 * (outlier + std::log(mixture_.inlier_weight / mixture_.outlier_weight));
}

SwitchedClosures::Closure& SwitchedClosures::edit(std::size_t k) {
  saved_.edited.try_emplace(k, closures_[k]);
  return closures_[k];
}

void SwitchedClosures::add(const ContinuousFactorPtr& factor, std::size_t first, Delta& delta) {
  const std::size_t k = closures_.size();
  alternatives_.add(first);
  closures_.emplace_back();
  closures_.back().factor = factor;
  ++out_;
  delta.hybrid.push_back(closure_mixture(k, factor, mixture_));
  delta.assignment.set(closure_switch(k).key, 1);
  set_switch(k, SwitchState::kFixedOutlier, delta);
}

void SwitchedClosures::set_switch(std::size_t k, SwitchState switch_state, Delta& delta) {
  Closure& closure = edit(k);
  if (closure.table.valid()) delta.remove.push_back(closure.table);
  closure.table = {};
  out_ -= closure.switch_state == SwitchState::kFixedOutlier ? 1 : 0;
  out_ += switch_state == SwitchState::kFixedOutlier ? 1 : 0;
  closure.switch_state = switch_state;
  if (switch_state == SwitchState::kFree) return;
  delta.discrete.emplace_back(std::vector<DiscreteKey>{closure_switch(k)},
                              switch_state == SwitchState::kFixedInlier
                                  ? std::vector<double>{0.0, kInfinity}
                                  : std::vector<double>{kInfinity, 0.0});
  changed_.push_back(k);
}

void SwitchedClosures::free(std::size_t k) {
  Closure& closure = edit(k);
  if (closure.table.valid()) lifted_.push_back(closure.table);
  closure.table = {};
  out_ -= closure.switch_state == SwitchState::kFixedOutlier ? 1 : 0;
  closure.switch_state = SwitchState::kFree;
}

UpdateReport SwitchedClosures::apply(Delta delta, IncrementalSmoother& smoother) {
  delta.remove.insert(delta.remove.end(), lifted_.begin(), lifted_.end());
  const UpdateReport report = taken(smoother.update(delta));
  lifted_.clear();
  const std::size_t first = delta.discrete.size() - changed_.size();
  for (std::size_t i = 0; i < changed_.size(); ++i) {
    edit(changed_[i]).table = report.handles.discrete[first + i];
  }
  changed_.clear();
  return report;
}

void SwitchedClosures::begin_change() {
  saved_ = {{}, closures_.size(), out_, lifted_};
}

void SwitchedClosures::undo_change() {
  for (auto& [k, closure] : saved_.edited) closures_[k] = std::move(closure);
  saved_.edited.clear();
  closures_.resize(saved_.size);
  alternatives_.resize(saved_.size);
  out_ = saved_.out;
  lifted_ = std::move(saved_.lifted);
  changed_.clear();
}

SwitchedClosures::Before SwitchedClosures::before(std::size_t k) {
  return {k, edit(k), lifted_, out_};
}

void SwitchedClosures::take_back(Before before) {
  closures_[before.closure] = std::move(before.state);
  lifted_ = std::move(before.lifted);
  out_ = before.out;
  changed_.clear();
}

}  // namespace hybrid
