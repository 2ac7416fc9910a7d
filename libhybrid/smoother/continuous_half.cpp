// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, the hybrid mapping authors
// The continuous half-step of the smoother (eq. 8b, 9b).
#include <algorithm>
#include <cmath>
#include <vector>

#include "libhybrid/core/detail/prefetch.h"
#include "libhybrid/core/detail/sort_unique.h"
#include "libhybrid/smoother/incremental.h"

namespace hybrid {
namespace {

/// Gauss-Newton steps that a half-step may take beyond the first.
constexpr int kMoreSteps = 3;
/// Terms whose factors are loaded ahead: the time of some evaluations is that of a load.
constexpr std::size_t kAhead = 4;
/// Of a factor between two variables with their noise; of larger ones the beginning.
constexpr std::size_t kFactorBytes = 256;

}  // namespace

/// Moves the linearisation points of some variables to the estimate and linearises their factors
/// there.
void IncrementalSmoother::move_linearization(const std::vector<int>& slots, UpdateReport& report) {
  for (int slot : slots) {
    if (!theta_->occupied(slot)) continue;
    std::copy_n(values().data(slot), theta_->type(slot).size, theta_.edit(slot));
    tree_.reset_delta(slot);
    ++report.relinearized;
  }
  touch(slots);
  for (int t : touched_) {
    const bool in_tree = terms_[t].tree_factor >= 0 || !terms_[t].pulls.empty();
    if (in_tree) linearize(terms_.edit(t), theta_.get(), tree_);
  }
}

/// Lowers the objective over the continuous variables (eq. 9b): the Gauss-Newton step of the tree;
/// where it does not lower the objective as its linear model promised, some more of them with all
/// that moved linearised again; and where that does not help, damped steps. A step that raises the
/// objective is not taken where its linear model promises less than linear models may be off by:
/// what is left is rounding, which in a long chain no new linearisation mends. Where it raises the
/// objective by less than that, part of it is enough.
void IncrementalSmoother::continuous_step(UpdateReport& report) {
  ++report.rounds;
  const double before = term_cost_.value();
  old_slots_.clear();
  old_.clear();
  ++old_stamp_;
  const double negligible = std::min(leeway_.relinearize, leeway_.minor);
  double promised = 0.0;
  for (int tries = 0;; ++tries) {
    changed_ = tree_.solve(leeway_.wildfire);
    remember(changed_);
    move_estimate();
    const double gained = before - term_cost_.value();
    if (tries == 0) promised = gained + model_error_;
    if (gained >= 0.0 && !falls_short(gained, promised)) break;
    const Place start{old_slots_, old_};
    if (gained < 0.0 && gained + model_error_ <= negligible) {
      go_along(start, way_from(start), 0.0);
      break;
    }
    if (gained >= -negligible && !falls_short(gained, promised)) {
      go_part_of_the_way(start, before);
      break;
    }
    if (tries == kMoreSteps) {
      fall_back(before, promised, report);
      break;
    }
    // All that moved, not just the ends of the worst factors: a variable that is linearised again
    // beside one that is not spoils the models of the factors between them, one more at each step.
    const std::vector<int> moved = changed_;
    moved_.clear();
    move_linearization(moved, report);
    if (!eliminate(report)) {
      report.status = UpdateReport::Status::kOk;
      fall_back(before, promised, report);
      break;
    }
  }
  record(report);
}

/// Keeps the estimates of some variables as they were before this half-step.
void IncrementalSmoother::remember(const std::vector<int>& slots) {
  if (static_cast<int>(slot_stamp_.size()) < theta_->slot_count())
    slot_stamp_.resize(theta_->slot_count());
  for (int slot : slots) {
    if (slot_stamp_[slot] == old_stamp_) continue;
    slot_stamp_[slot] = old_stamp_;
    const double* x = values().data(slot);
    old_slots_.push_back(slot);
    old_.insert(old_.end(), x, x + values().type(slot).size);
  }
}

/// Sets the estimate of the changed variables from their steps, and the costs of their factors.
void IncrementalSmoother::move_estimate() {
  for (int slot : changed_) {
    retract(theta_->type(slot), theta_->data(slot), tree_.delta(slot), estimate_.edit(slot));
  }
  refresh_costs(changed_);
}

/// Begins to load what the next few of the touched terms need: most of the time of a refresh is
/// spent waiting for memory.
void IncrementalSmoother::fetch_ahead(std::size_t k) const {
  if (k + 2 * kAhead < touched_.size()) terms_.prefetch(touched_[k + 2 * kAhead]);
  if (k + kAhead >= touched_.size()) return;
  const Term& term = terms_[touched_[k + kAhead]];
  prefetch(term.component.factor, kFactorBytes);
  if (term.tree_factor >= 0) tree_.prefetch(term.tree_factor);
}

/// Lists the terms of some variables, each once, as `touched_`.
void IncrementalSmoother::touch(const std::vector<int>& slots) {
  touched_.clear();
  ++stamp_;
  for (int slot : slots) {
    for (int t : terms_.of_variable(slot)) {
      if (term_stamp_[t] == stamp_) continue;
      term_stamp_[t] = stamp_;
      touched_.push_back(t);
    }
  }
}

/// Brings the costs of the factors of some variables up to date and lists, as `moved_`, the
/// variables of those whose linear model is off.
void IncrementalSmoother::refresh_costs(const std::vector<int>& slots) {
  touch(slots);
  errors_.clear();
  model_error_ = 0.0;
  double change = 0.0;
  for (std::size_t k = 0; k < touched_.size(); ++k) {
    fetch_ahead(k);
    const int t = touched_[k];
    if (!terms_[t].alive) continue;
    Term& term = terms_.edit(t);
    const double cost = evaluate(term, values());
    if (std::isfinite(cost) && std::isfinite(term.cost)) {
      change += cost - term.cost;
    } else {
      term_cost_.subtract(term.cost);
      term_cost_.add(cost);
    }
    term.cost = cost;
    if (term.hybrid != nullptr) stale_.push_back(t);
    if (term.tree_factor < 0) continue;
    const double error =
        cost - term.constant - term.model_offset - tree_.linear_cost(term.tree_factor);
    model_error_ += error;
    errors_.emplace_back(std::isfinite(error) ? std::abs(error) : INFINITY, t);
  }
  term_cost_.add(change);
  choose_moved();
}

/// Lists, as `moved_`, the variables of factors whose linear model is off by more than is left
/// undone.
void IncrementalSmoother::choose_moved() {
  moved_.clear();
  open_ = 0.0;
  for (const auto& [error, t] : errors_) {
    if (error <= leeway_.relinearize || t >= terms_.count() || !terms_[t].alive) continue;
    open_ += error;
    moved_.insert(moved_.end(), terms_[t].slots.begin(), terms_[t].slots.end());
  }
  sort_unique(moved_);
}

}  // namespace hybrid
