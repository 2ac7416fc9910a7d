// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, the hybrid mapping authors
#include "libhybrid/smoother/incremental.h"

#include <algorithm>
#include <chrono>
#include <cmath>
#include <string>
#include <utility>

#include "libhybrid/core/elapsed.h"

namespace hybrid {
namespace {

/// Gauss-Newton steps that a half-step may take beyond the first.
constexpr int kMoreSteps = 3;

}  // namespace

// Algorithm (section IV): D given C for what was touched; then rounds of C given D and D given C.
UpdateReport IncrementalSmoother::update(const Delta& delta) {
  const auto start = std::chrono::steady_clock::now();
  check(delta);
  UpdateReport report;
  Staged staged;
  try {
    staged = stage(delta, report);
    record(report);
    report.objective_before = objective();
    discrete_step(report);
    enter_new_terms(report.handles);
  } catch (...) {
    tree_.abandon();
    undo();
    throw;
  }
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
  continuous_step(report, options_.wildfire, kMoreSteps);
  while (discrete_step(report) && take_flips(report) && report.rounds < options_.rounds) {
    continuous_step(report, options_.wildfire, kMoreSteps);
  }
  report.objective_after = objective();
  report.seconds = seconds_since(start);
  return report;
}

UpdateReport IncrementalSmoother::converge(int max_rounds, double tolerance) {
  const auto start = std::chrono::steady_clock::now();
  UpdateReport report;
  report.objective_before = objective();
  int more_steps = kMoreSteps;
  while (report.rounds < max_rounds) {
    const double before = objective();
    std::vector<int> all;
    for (int slot = 0; slot < theta_.slot_count(); ++slot) {
      if (theta_.occupied(slot)) all.push_back(slot);
    }
    enter_pulls();
    move_linearization(all, report);
    if (!eliminate(report)) {
      undo();
      break;
    }
    undo_.clear();
    const bool stuck = !continuous_step(report, 0.0, more_steps);
    const bool flipped = discrete_step(report) && take_flips(report);
    // Several steps on end need not lead downhill; one Gauss-Newton step does, if short enough.
    const bool again = stuck && more_steps > 0;
    more_steps = again ? 0 : kMoreSteps;
    if (!flipped && !again && before - objective() <= tolerance * std::max(1.0, std::abs(before)))
      break;
  }
  report.objective_after = objective();
  report.seconds = seconds_since(start);
  return report;
}

double IncrementalSmoother::objective() const {
  return term_cost_.value() + discrete_.pure_cost();
}

double IncrementalSmoother::cost() const {
  return hybrid::cost(graph_, estimate_, assignment());
}

void IncrementalSmoother::enter_tree(int t) {
  Term& term = terms_[t];
  if (!belongs_in_tree(term.component)) return;
  term.tree_factor = tree_.add_factor(active_slots(term));
  linearize(term, theta_, tree_);
}

void IncrementalSmoother::leave_tree(int t) {
  Term& term = terms_[t];
  if (term.tree_factor >= 0) tree_.remove_factor(term.tree_factor);
  for (int f : term.pulls) tree_.remove_factor(f);
  term.tree_factor = -1;
  term.pulls.clear();
}

/// Lets weak components pull at their variables, so that the estimate converges to the exact
/// optimum.
void IncrementalSmoother::enter_pulls() {
  for (int t = 0; t < terms_.count(); ++t) {
    Term& term = terms_[t];
    if (!term.alive || term.component.factor == nullptr || !term.component.weak ||
        !term.pulls.empty())
      continue;
    undo_.push_back([this, t] { terms_[t].pulls.clear(); });
    for (int slot : active_slots(term)) term.pulls.push_back(tree_.add_factor({slot}));
    linearize(term, theta_, tree_);
  }
}

/// Chooses another component of a hybrid term. A new linearisation always goes with it: a stale one
/// would leave the mode right and the pose wrong.
void IncrementalSmoother::set_component(int t, const Component& component) {
  Term& term = terms_[t];
  const std::vector<int> before = term.tree_factor >= 0 ? active_slots(term) : std::vector<int>{};
  undo_.push_back([this, t, component = term.component, tree_factor = term.tree_factor,
                   pulls = term.pulls, cost = term.cost] {
    term_cost_.subtract(terms_[t].cost);
    term_cost_.add(cost);
    term_constant_.subtract(constant_of(terms_[t].component));
    term_constant_.add(constant_of(component));
    terms_[t].component = component;
    terms_[t].tree_factor = tree_factor;
    terms_[t].pulls = pulls;
    terms_[t].cost = cost;
  });
  const int previous = term.component.index;
  term_constant_.subtract(constant_of(term.component));
  term_constant_.add(constant_of(component));
  term.component = component;
  term_cost_.subtract(term.cost);
  term.cost = evaluate(term, estimate_);
  term_cost_.add(term.cost);
  const bool same_place =
      term.tree_factor >= 0 && belongs_in_tree(component) && active_slots(term) == before;
  if (same_place && component.index == previous) return;
  if (same_place) {
    linearize(term, theta_, tree_);
    return;
  }
  leave_tree(t);
  enter_tree(t);
}

/// Brings the flips of the last discrete half-step into the tree, or takes them back where the
/// system would be singular with them.
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

/// Moves the linearisation points of some variables to the estimate and linearises their factors
/// there.
void IncrementalSmoother::move_linearization(const std::vector<int>& slots, UpdateReport& report) {
  std::vector<std::pair<int, std::vector<double>>> before;
  std::vector<int> terms;
  ++stamp_;
  for (int slot : slots) {
    if (!theta_.occupied(slot)) continue;
    const VariableType type = theta_.type(slot);
    before.emplace_back(slot,
                        std::vector<double>(theta_.data(slot), theta_.data(slot) + type.size));
    std::copy_n(estimate_.data(slot), type.size, theta_.data(slot));
    tree_.reset_delta(slot);
    ++report.relinearized;
    for (int t : terms_.of_variable(slot)) {
      if (term_stamp_[t] == stamp_) continue;
      term_stamp_[t] = stamp_;
      if (terms_[t].tree_factor >= 0 || !terms_[t].pulls.empty()) terms.push_back(t);
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

/// Lowers the objective over the continuous variables (eq. 9b): the Gauss-Newton step of the tree;
/// where the true objective rises with it, some more of them with all that moved linearised again;
/// and where that does not help, a part of the way. Returns false where it stays put.
bool IncrementalSmoother::continuous_step(UpdateReport& report, double wildfire, int more_steps) {
  ++report.rounds;
  const double before = term_cost_.value();
  old_slots_.clear();
  old_.clear();
  ++old_stamp_;
  bool moved_on = true;
  for (int tries = 0;; ++tries) {
    changed_ = tree_.solve(wildfire);
    remember(changed_);
    move_estimate();
    if (term_cost_.value() <= before) break;
    if (tries == more_steps) {
      moved_on = back_off(before);
      break;
    }
    // All that moved, not just the ends of the worst factors: a variable that is linearised again
    // beside one that is not spoils the models of the factors between them, one more at each step.
    const std::vector<int> moved = changed_;
    moved_.clear();
    move_linearization(moved, report);
    if (!eliminate(report)) {
      undo();
      report.status = UpdateReport::Status::kOk;
      moved_on = back_off(before);
      break;
    }
    undo_.clear();
  }
  record(report);
  return moved_on;
}

/// Keeps the estimates of some variables as they were before this half-step.
void IncrementalSmoother::remember(const std::vector<int>& slots) {
  if (static_cast<int>(slot_stamp_.size()) < theta_.slot_count())
    slot_stamp_.resize(theta_.slot_count());
  for (int slot : slots) {
    if (slot_stamp_[slot] == old_stamp_) continue;
    slot_stamp_[slot] = old_stamp_;
    const double* x = estimate_.data(slot);
    old_slots_.push_back(slot);
    old_.insert(old_.end(), x, x + estimate_.type(slot).size);
  }
}

/// Sets the estimate of the changed variables from their steps, and the costs of their factors.
void IncrementalSmoother::move_estimate() {
  for (int slot : changed_) {
    retract(theta_.type(slot), theta_.data(slot), tree_.delta(slot), estimate_.data(slot));
  }
  refresh_costs(changed_);
}

/// Brings the costs of the factors of some variables up to date and lists, as `moved_`, the
/// variables of those whose linear model is off.
void IncrementalSmoother::refresh_costs(const std::vector<int>& slots) {
  errors_.clear();
  double change = 0.0;
  ++stamp_;
  for (int slot : slots) {
    for (int t : terms_.of_variable(slot)) {
      if (term_stamp_[t] == stamp_) continue;
      term_stamp_[t] = stamp_;
      Term& term = terms_[t];
      if (!term.alive) continue;
      const double cost = evaluate(term, estimate_);
      if (std::isfinite(cost) && std::isfinite(term.cost)) {
        change += cost - term.cost;
      } else {
        term_cost_.subtract(term.cost);
        term_cost_.add(cost);
      }
      term.cost = cost;
      if (term.hybrid != nullptr) stale_.push_back(t);
      if (term.tree_factor < 0) continue;
      const double fixed = term.component.constant + term.component.factor->log_normalizer();
      const double error = cost - fixed - tree_.linear_cost(term.tree_factor);
      errors_.emplace_back(std::isfinite(error) ? std::abs(error) : INFINITY, t);
    }
  }
  term_cost_.add(change);
  choose_moved();
}

/// Lists, as `moved_`, the variables of factors whose linear model is off by more than the option
/// says.
void IncrementalSmoother::choose_moved() {
  moved_.clear();
  for (const auto& [error, t] : errors_) {
    if (error <= options_.relinearize) continue;
    moved_.insert(moved_.end(), terms_[t].slots.begin(), terms_[t].slots.end());
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

/// Solves the touched discrete components (eq. 8a) and changes the components of hybrid factors
/// that follow. Returns whether any variable flipped.
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
