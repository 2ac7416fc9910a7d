// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, the hybrid mapping authors
#include "libhybrid/smoother/incremental.h"

#include <algorithm>
#include <chrono>
#include <cmath>
#include <string>
#include <utility>

namespace hybrid {
namespace {

double seconds_since(std::chrono::steady_clock::time_point start) {
  return std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count();
}

}  // namespace

// Algorithm (section IV): D given C for what was touched; then rounds of C given D and D given C.
UpdateReport IncrementalSmoother::update(const Delta& delta) {
  const auto start = std::chrono::steady_clock::now();
  check(delta);
  UpdateReport report;
  const Staged staged = stage(delta, report);
  record(report);
  report.objective_before = objective();
  discrete_step(report);
  std::vector<int> moved;
  moved.swap(moved_);
  move_linearization(moved, report);
  if (!eliminate(report)) {
    undo();
    moved_.swap(moved);
    report.handles.clear();
    report.seconds = seconds_since(start);
    return report;
  }
  commit(staged);
  continuous_step(report, options_.wildfire);
  while (discrete_step(report) && report.rounds < options_.rounds && take_flips(report)) {
    continuous_step(report, options_.wildfire);
  }
  report.objective_after = objective();
  report.seconds = seconds_since(start);
  return report;
}

UpdateReport IncrementalSmoother::converge(int max_rounds, double tolerance) {
  const auto start = std::chrono::steady_clock::now();
  UpdateReport report;
  report.objective_before = objective();
  while (report.rounds < max_rounds) {
    const double before = objective();
    std::vector<int> all;
    for (int slot = 0; slot < theta_.slot_count(); ++slot) {
      if (theta_.occupied(slot)) all.push_back(slot);
    }
    move_linearization(all, report);
    if (!eliminate(report)) {
      undo();
      break;
    }
    undo_.clear();
    continuous_step(report, 0.0);
    const bool flipped = discrete_step(report);
    if (!flipped && before - objective() <= tolerance * std::max(1.0, std::abs(before))) break;
  }
  report.objective_after = objective();
  report.seconds = seconds_since(start);
  return report;
}

double IncrementalSmoother::objective() const { return term_cost_ + discrete_.pure_cost(); }

double IncrementalSmoother::cost() const { return hybrid::cost(graph_, estimate_, assignment()); }

void IncrementalSmoother::enter_tree(int t) {
  Term& term = terms_[t];
  if (!belongs_in_tree(term.component)) return;
  term.tree_factor = tree_.add_factor(active_slots(term));
  linearize(term, theta_, tree_);
}

void IncrementalSmoother::leave_tree(int t) {
  if (terms_[t].tree_factor < 0) return;
  tree_.remove_factor(terms_[t].tree_factor);
  terms_[t].tree_factor = -1;
}

/// Chooses another component of a hybrid term. A new linearisation always goes with it: a stale one would
/// leave the mode right and the pose wrong.
void IncrementalSmoother::set_component(int t, const Component& component) {
  Term& term = terms_[t];
  const std::vector<int> before = term.tree_factor >= 0 ? active_slots(term) : std::vector<int>{};
  undo_.push_back([this, t, component = term.component, tree_factor = term.tree_factor, cost = term.cost] {
    term_cost_ += cost - terms_[t].cost;
    terms_[t].component = component;
    terms_[t].tree_factor = tree_factor;
    terms_[t].cost = cost;
  });
  const int previous = term.component.index;
  term.component = component;
  term_cost_ -= term.cost;
  term.cost = evaluate(term, estimate_);
  term_cost_ += term.cost;
  const bool same_place = term.tree_factor >= 0 && belongs_in_tree(component) && active_slots(term) == before;
  if (same_place && component.index == previous) return;
  if (same_place) {
    linearize(term, theta_, tree_);
    return;
  }
  leave_tree(t);
  enter_tree(t);
}

/// Brings the flips of the last discrete half-step into the tree, or takes them back where the system would
/// be singular with them.
bool IncrementalSmoother::take_flips(UpdateReport& report) {
  if (eliminate(report)) {
    undo_.clear();
    return true;
  }
  undo();
  report.status = UpdateReport::Status::kOk;
  report.message += " in the mode that its discrete variables prefer; they were left as they were";
  report.objectives.pop_back();
  return false;
}

/// Moves the linearisation points of some variables to the estimate and linearises their factors there.
void IncrementalSmoother::move_linearization(const std::vector<int>& slots, UpdateReport& report) {
  std::vector<std::pair<int, std::vector<double>>> before;
  std::vector<int> terms;
  ++stamp_;
  for (int slot : slots) {
    if (!theta_.occupied(slot)) continue;
    const VariableType type = theta_.type(slot);
    before.emplace_back(slot, std::vector<double>(theta_.data(slot), theta_.data(slot) + type.size));
    std::copy_n(estimate_.data(slot), type.size, theta_.data(slot));
    tree_.reset_delta(slot);
    ++report.relinearized;
    for (int t : terms_.of_variable(slot)) {
      if (term_stamp_[t] == stamp_) continue;
      term_stamp_[t] = stamp_;
      if (terms_[t].tree_factor >= 0) terms.push_back(t);
    }
  }
  for (int t : terms) linearize(terms_[t], theta_, tree_);
  undo_.push_back([this, before = std::move(before)] {
    for (const auto& [slot, x] : before) std::copy(x.begin(), x.end(), theta_.data(slot));
  });
}

bool IncrementalSmoother::eliminate(UpdateReport& report) {
  const EliminationReport done = tree_.eliminate(last_);
  report.eliminated += done.variables;
  report.cliques += done.cliques;
  if (done.singular < 0) return true;
  report.status = UpdateReport::Status::kSingular;
  report.under_constrained = theta_.key(done.singular);
  report.message = "the factors do not determine " + to_string(report.under_constrained) +
                   "; give it a prior or more measurements";
  return false;
}

/// Takes the Gauss-Newton step of the tree, shortened where the true objective would rise (eq. 9b).
void IncrementalSmoother::continuous_step(UpdateReport& report, double wildfire) {
  changed_ = tree_.solve(wildfire);
  ++report.rounds;
  const double before = term_cost_;
  const double rise = move_estimate();
  if (rise > 0.0) {
    if (!shorten(before)) {
      move_linearization(changed_, report);
      if (eliminate(report)) {
        undo_.clear();
        changed_ = tree_.solve(wildfire);
        if (move_estimate() > 0.0) shorten(before);
      } else {
        undo();
        report.status = UpdateReport::Status::kOk;
      }
    }
  }
  collect_moved();
  record(report);
}

/// Sets the estimate of the changed variables from their steps. Returns by how much the objective rises.
double IncrementalSmoother::move_estimate() {
  for (int slot : changed_) {
    retract(theta_.type(slot), theta_.data(slot), tree_.delta(slot), estimate_.data(slot));
  }
  const double before = term_cost_;
  double change = 0.0;
  ++stamp_;
  for (int slot : changed_) {
    for (int t : terms_.of_variable(slot)) {
      if (term_stamp_[t] == stamp_) continue;
      term_stamp_[t] = stamp_;
      Term& term = terms_[t];
      if (!term.alive) continue;
      const double cost = evaluate(term, estimate_);
      change += cost - term.cost;
      term.cost = cost;
      if (term.hybrid != nullptr) stale_.push_back(t);
    }
  }
  term_cost_ = before + change;
  return std::isfinite(change) ? change : INFINITY;
}

/// Halves the last change until the objective is no higher than `before`; gives it up if that never happens.
bool IncrementalSmoother::shorten(double before) {
  for (double share = 0.5; share > 1e-3; share *= 0.5) {
    tree_.scale_change(share);
    move_estimate();
    if (term_cost_ <= before) return true;
  }
  tree_.scale_change(0.0);
  move_estimate();
  term_cost_ = before;
  return false;
}

bool IncrementalSmoother::too_far(int slot) const {
  const VariableType type = theta_.type(slot);
  const double* step = tree_.delta(slot);
  const auto exceeds = [&](int from, int to, double threshold) {
    for (int i = from; i < to; ++i) {
      if (std::abs(step[i]) > threshold) return true;
    }
    return false;
  };
  int translation = 0;
  if (type.kind == VariableKind::kVector) translation = type.dim;
  if (type.kind == VariableKind::kSE2) translation = 2;
  if (type.kind == VariableKind::kSE3) translation = 3;
  return exceeds(0, translation, options_.relinearize_translation) ||
         exceeds(translation, type.dim, options_.relinearize_rotation);
}

void IncrementalSmoother::collect_moved() {
  for (int slot : changed_) {
    if (too_far(slot)) moved_.push_back(slot);
  }
  std::sort(moved_.begin(), moved_.end());
  moved_.erase(std::unique(moved_.begin(), moved_.end()), moved_.end());
}

/// Tables of hybrid factors whose variables have moved.
void IncrementalSmoother::refresh_tables() {
  std::sort(stale_.begin(), stale_.end());
  stale_.erase(std::unique(stale_.begin(), stale_.end()), stale_.end());
  std::vector<const double*> x;
  for (int t : stale_) {
    const Term& term = terms_[t];
    if (!term.alive || term.hybrid == nullptr) continue;
    x.clear();
    for (int slot : term.slots) x.push_back(estimate_.data(slot));
    discrete_.set_tables(table_of_term_[t], term.hybrid->given(x.data()));
  }
  stale_.clear();
}

/// Solves the touched discrete components (eq. 8a) and changes the components of hybrid factors that
/// follow. Returns whether any variable flipped.
bool IncrementalSmoother::discrete_step(UpdateReport& report) {
  refresh_tables();
  const DiscreteHalf::Report done = discrete_.solve(options_.discrete);
  report.components += done.components;
  report.exact = report.exact && done.exact;
  report.flips += static_cast<int>(done.flips.size());
  for (const DiscreteHalf::Flip& flip : done.flips) {
    undo_.push_back([this, flip] { discrete_.restore(flip.key, flip.from); });
    for (int f : discrete_.factors_of(flip.key)) {
      const int t = discrete_.owner(f);
      if (t >= 0 && terms_[t].alive) set_component(t, terms_[t].hybrid->given(assignment()));
    }
  }
  if (!done.flips.empty()) record(report);
  return !done.flips.empty();
}

Eigen::MatrixXd IncrementalSmoother::joint_covariance(const std::vector<Key>& keys) const {
  std::vector<int> slots;
  for (Key key : keys) slots.push_back(theta_.slot(key));
  return tree_.joint_covariance(slots);
}

void IncrementalSmoother::visit_covariances(
    const std::function<void(Key, const Eigen::MatrixXd&)>& visit) const {
  tree_.visit_covariances(
      [&](int slot, const Eigen::MatrixXd& covariance) { visit(theta_.key(slot), covariance); });
}

}  // namespace hybrid
