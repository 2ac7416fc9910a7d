// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, the hybrid mapping authors
// The continuous half-step of the smoother (eq. 8b, 9b).
#include <algorithm>
#include <array>
#include <cmath>
#include <vector>

#include "libhybrid/core/detail/prefetch.h"
#include "libhybrid/core/paced_task.h"
#include "libhybrid/smoother/detail/map_of.h"
#include "libhybrid/smoother/incremental.h"

namespace hybrid {
namespace {

/// Gauss-Newton steps that a half-step may take beyond the first.
constexpr int kMoreSteps = 3;
/// Terms whose factors are loaded ahead: the time of some evaluations is that of a load.
constexpr std::size_t kAhead = 4;
/// Of a factor between two variables with their noise; of larger ones the beginning.
constexpr std::size_t kFactorBytes = 256;
/// Of a factor, where its noise is as stated: half for each of its rows, of which it has two or
/// more.
constexpr double kCostByNoise = 1.0;
/// Multiplications in the time that it takes to evaluate or linearise a term, about.
constexpr double kWorkOfTerm = 500.0;

}  // namespace

/// The step of the tree, and the costs of the factors that it changes.
void IncrementalSmoother::solve(const Leeway& leeway) {
  slot_stamp_.resize(std::max(slot_stamp_.size(), std::size_t(values().slot_count())));
  const MapOf map(*this);
  changed_ = tree_.solve(leeway.wildfire, bend_of(leeway), map.charts());
  touch(changed_);
  touch_untied();
  refresh_costs();
}

/// By how much parts of the map may stay bent.
Bend IncrementalSmoother::bend_of(const Leeway& leeway) const {
  const auto factors = static_cast<double>(graph_.continuous().size() + graph_.hybrid().size());
  const double cost = term_cost_.value() - term_constant_.value();
  const double mean = std::clamp(cost / std::max(factors, 1.0), 0.0, kCostByNoise);
  return {leeway.bend, leeway.bend_share * mean};
}

/// Adds to the touched terms the hybrid ones of which the tree does not know that they tie their
/// variables, and of which one has moved: parts of the tree may have moved past each other.
void IncrementalSmoother::touch_untied() {
  if (graph_.hybrid().size() == 0) return;
  const auto before = static_cast<std::ptrdiff_t>(touched_.size());
  for (int slot : old_.slots) {
    for (int t : terms_.of_variable(slot)) {
      const Term& term = terms_[t];
      if (!term.alive || term.hybrid == nullptr || term_stamp_[t] == stamp_) continue;
      const bool tied =
          term.tree_factor >= 0 && term.component.factor->keys().size() == term.slots.size();
      if (tied) continue;
      term_stamp_[t] = stamp_;
      touched_.push_back(t);
    }
  }
  std::sort(touched_.begin() + before, touched_.end());
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
  old_.slots.clear();
  old_.numbers.clear();
  ++old_stamp_;
  const double negligible = std::min(leeway_.relinearize, leeway_.minor);
  double from = before;  // the objective when the models were last made again
  double promised = 0.0;
  for (int tries = 0;; ++tries) {
    solve(leeway_);
    const double gained = before - term_cost_.value();
    const double by_models = from - term_cost_.value() + model_error_;
    if (tries == 0) promised = by_models;
    if (gained >= 0.0 && !falls_short(gained, promised)) break;
    const Place start = old_;
    if (gained < 0.0 && by_models <= negligible) {
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
    // All that moved, not just the worst factors.
    touch(changed_);
    off_.clear();
    make_models_again(touched_, report);
    from = term_cost_.value();
    if (!eliminate(report)) {
      report.status = UpdateReport::Status::kOk;
      fall_back(before, promised, report);
      break;
    }
  }
  record(report);
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

/// What the linear model of a term says of its cost at the estimate, less constants.
double IncrementalSmoother::model_cost(const Term& term) const {
  constexpr int kFew = 32;
  std::array<double, kFew> few;
  const ContinuousFactor& factor = *term.component.factor;
  std::vector<double> many(factor.cols() > kFew ? factor.cols() : 0);
  double* steps = many.empty() ? few.data() : many.data();
  steps_from(map_kind_, tree_.chart_of(term.tree_factor), factor.types(),
             TermPointers(term, values()).data(), steps);
  return tree_.linear_cost(term.tree_factor, steps);
}

/// Brings the costs of the factors of some variables up to date.
void IncrementalSmoother::refresh_costs(const std::vector<int>& slots) {
  touch(slots);
  refresh_costs();
}

/// Brings the costs of the touched terms up to date and lists, as `off_`, those whose linear model
/// is off.
void IncrementalSmoother::refresh_costs() {
  note_work(kWorkOfTerm * double(touched_.size()));
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
    const double error = cost - term.constant - term.model_offset - model_cost(term);
    model_error_ += error - term.model_error;
    term.model_error = std::isfinite(error) ? error : 0.0;
    errors_.emplace_back(std::isfinite(error) ? std::abs(error) : INFINITY, t);
  }
  term_cost_.add(change);
  choose_off();
}

/// Lists, as `off_`, the factors whose linear model is off by more than is left undone.
void IncrementalSmoother::choose_off() {
  off_.clear();
  open_ = 0.0;
  for (const auto& [error, t] : errors_) {
    if (error <= leeway_.relinearize || t >= terms_.count() || !terms_[t].alive) continue;
    open_ += error;
    off_.push_back(t);
  }
}

/// Lets the next elimination linearise some terms again.
void IncrementalSmoother::make_models_again(const std::vector<int>& terms, UpdateReport& report) {
  for (int t : terms) {
    if (t >= terms_.count() || !terms_[t].alive) continue;
    if (terms_[t].tree_factor >= 0) tree_.assemble_again(terms_[t].tree_factor);
    for (int f : terms_[t].pulls) tree_.assemble_again(f);
    ++report.relinearized;
  }
}

/// Linearises what is to be eliminated, at the estimate.
void IncrementalSmoother::linearize_eliminated() {
  int last = -1;  // the pulls of a term are neighbours
  for (int f : tree_.factors_to_assemble()) {
    const int t = f < static_cast<int>(term_of_factor_.size()) ? term_of_factor_[f] : -1;
    if (t < 0 || t == last) continue;
    linearize(terms_.edit(t), values(), tree_);
    note_work(kWorkOfTerm);
    last = t;
  }
}

}  // namespace hybrid
