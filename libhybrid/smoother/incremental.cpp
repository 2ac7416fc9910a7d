// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, the hybrid mapping authors
#include "libhybrid/smoother/incremental.h"

#include <algorithm>
#include <chrono>
#include <cmath>
#include <numeric>
#include <string>
#include <utility>

#include "libhybrid/core/detail/sort_unique.h"
#include "libhybrid/core/elapsed.h"
#include "libhybrid/smoother/detail/map_of.h"

namespace hybrid {
namespace {

/// What is too little for an update to matter, in units of the objective: the next ones go on.
constexpr double kMinorGain = 1.0;

/// What `settle` may leave undone, as a share of what updates may: where decisions compare
/// objectives, it must be far below what decides.
constexpr double kSettled = 1e-2;

}  // namespace

/// Runs change(report), which makes the smoother what it will be. Where it throws, or leaves a
/// status other than kOk, all is taken back, or what came since the newest mark.
template <class Change>
UpdateReport IncrementalSmoother::all_or_nothing(const Change& change) {
  const auto start = std::chrono::steady_clock::now();
  const bool own = !in_transaction_;
  UpdateReport report;
  report.objective_before = objective();
  start_change();
  try {
    change(report);
  } catch (...) {
    undo_failed();
    throw;
  }
  if (report.status != UpdateReport::Status::kOk) {
    undo_failed();
    report.handles = {};
  } else {
    list_changed(report);
    if (own) make_permanent();
  }
  report.objective_after = objective();
  report.seconds = seconds_since(start);
  return report;
}

void IncrementalSmoother::list_changed(UpdateReport& report) const {
  const auto add = [&](Key key) {
    if (!estimate_.is_removed(key)) report.changed.push_back(key);
  };
  for (int slot : estimate_.edited()) add(values().key(slot));
  for (Key key : estimate_.inserted()) add(key);
  discrete_.list_changed(report.changed);
}

// Algorithm (section IV-B): D given C for what was touched; then rounds of C given D and D given C.
UpdateReport IncrementalSmoother::update(const Delta& delta) {
  return update(delta, usual_leeway());
}

IncrementalSmoother::Leeway IncrementalSmoother::usual_leeway() const {
  return {options_.relinearize, options_.wildfire, options_.bend, options_.bend_share, kMinorGain};
}

UpdateReport IncrementalSmoother::update(const Delta& delta, const Leeway& leeway) {
  return all_or_nothing([&](UpdateReport& report) {
    leeway_ = leeway;
    check(delta);
    stage(delta, report);
    record(report);
    report.objective_before = objective();
    discrete_step(report);
    enter_new_terms(report.handles);
    std::vector<int> off;
    off.swap(off_);
    make_models_again(off, report);
    if (eliminate_new(report)) alternate(report);
  });
}

/// Alternates until nothing flips and linear models are off by little in all, or for the rounds
/// that an update may take: a large innovation outruns the models of many factors at once.
void IncrementalSmoother::alternate(UpdateReport& report) {
  for (bool goes_on = true; goes_on;) {
    continuous_step(report);
    if (report.status != UpdateReport::Status::kOk) return;
    goes_on = discrete_step(report) && take_flips(report);
    if (report.rounds >= options_.rounds) break;
    if (!goes_on && open_ > leeway_.minor) goes_on = renew_models(report);
  }
  report.open = open_;
}

/// Makes those linear models again that are off. Returns whether there were any.
bool IncrementalSmoother::renew_models(UpdateReport& report) {
  if (off_.empty()) return false;
  std::vector<int> off;
  off.swap(off_);
  make_models_again(off, report);
  if (eliminate(report)) return true;
  report.status = UpdateReport::Status::kOk;
  return false;
}

UpdateReport IncrementalSmoother::settle(int max_updates) {
  Leeway fine = usual_leeway();
  for (double* of :
       {&fine.relinearize, &fine.wildfire, &fine.bend, &fine.bend_share, &fine.minor}) {
    *of *= kSettled;
  }
  leeway_ = fine;
  choose_off();
  UpdateReport report;
  report.objective_before = report.objective_after = objective();
  for (int k = 0; k < max_updates; ++k) {
    const double before = objective();
    const UpdateReport one = update({}, fine);
    report.go_on(one);
    if (one.status != UpdateReport::Status::kOk) break;
    if (one.flips == 0 && before - objective() <= fine.minor) break;
  }
  return report;
}

UpdateReport IncrementalSmoother::converge(int max_rounds, double tolerance) {
  return all_or_nothing([&](UpdateReport& report) {
    std::vector<int> all(terms_.count());
    std::iota(all.begin(), all.end(), 0);
    while (report.rounds < max_rounds) {
      const double before = objective();
      enter_pulls();
      make_models_again(all, report);
      if (!eliminate(report)) return;
      leeway_ = {options_.relinearize, 0.0, 0.0, tolerance * std::max(1.0, std::abs(before))};
      continuous_step(report);
      if (report.status != UpdateReport::Status::kOk) return;
      const bool flipped = discrete_step(report) && take_flips(report);
      const double decrease = before - objective();
      if (!flipped && decrease <= tolerance * std::max(1.0, std::abs(before))) return;
    }
  });
}

double IncrementalSmoother::cost() const {
  return hybrid::cost(graph_, values(), assignment());
}

void IncrementalSmoother::enter_tree(int t) {
  Term& term = terms_.edit(t);
  if (!belongs_in_tree(term.component)) {
    weak_left_out_ = weak_left_out_ || term.component.factor != nullptr;
    return;
  }
  term.tree_factor = tree_.add_factor(active_slots(term), point_size(*term.component.factor));
  own_factor(term.tree_factor, t);
  linearize(term, values(), tree_);
}

/// Notes whose factor of the tree it is.
void IncrementalSmoother::own_factor(int factor, int t) {
  if (factor >= static_cast<int>(term_of_factor_.size())) term_of_factor_.resize(factor + 1, -1);
  term_of_factor_[factor] = t;
}

void IncrementalSmoother::leave_tree(int t) {
  if (terms_[t].tree_factor >= 0) {
    lost_.push_back({terms_[t].component.factor, active_slots(terms_[t])});
  }
  take_out_of_tree(t);
}

void IncrementalSmoother::take_out_of_tree(int t) {
  Term& term = terms_.edit(t);
  if (term.tree_factor >= 0) tree_.remove_factor(term.tree_factor);
  for (int f : term.pulls) tree_.remove_factor(f);
  term.tree_factor = -1;
  term.pulls.clear();
}

/// Lets weak components pull at their variables, so that the estimate converges to the exact
/// optimum.
void IncrementalSmoother::enter_pulls() {
  for (int t = 0; t < terms_.count(); ++t) {
    if (!terms_[t].alive || terms_[t].component.factor == nullptr || terms_[t].tree_factor >= 0 ||
        !terms_[t].pulls.empty())
      continue;
    Term& term = terms_.edit(t);
    for (int slot : active_slots(term)) {
      term.pulls.push_back(tree_.add_factor({slot}));
      own_factor(term.pulls.back(), t);
    }
    linearize(term, values(), tree_);
  }
}

/// Chooses another component of a hybrid term. A new linearisation always goes with it: a stale one
/// would leave the mode right and the pose wrong.
void IncrementalSmoother::set_component(int t, const Component& component) {
  Term& term = terms_.edit(t);
  const std::vector<int> before = term.tree_factor >= 0 ? active_slots(term) : std::vector<int>{};
  const Component previous = term.component;
  term_constant_.subtract(term.constant);
  term.choose(component);
  term_constant_.add(term.constant);
  term_cost_.subtract(term.cost);
  term.cost = evaluate(term, values());
  term_cost_.add(term.cost);
  const bool same_place =
      term.tree_factor >= 0 && belongs_in_tree(component) && active_slots(term) == before;
  if (same_place && component.index == previous.index) return;
  if (term.tree_factor >= 0) lost_.push_back({previous.factor, before});
  if (same_place) {
    linearize(term, values(), tree_);
    return;
  }
  take_out_of_tree(t);
  enter_tree(t);
}

/// Solves the touched discrete components (eq. 8a) and changes the components of hybrid factors
/// that follow. Returns whether any variable flipped.
bool IncrementalSmoother::discrete_step(UpdateReport& report) {
  refresh_tables();
  DiscreteHalf::Report done = discrete_.solve(options_.discrete);
  report.components += done.components;
  report.exact = report.exact && done.exact;
  report.flips += static_cast<int>(done.flips.size());
  flips_ = std::move(done.flips);
  for (const DiscreteHalf::Flip& flip : flips_) choose_components(flip.key);
  if (!flips_.empty()) record(report);
  for (const DiscreteHalf::Flip& flip : flips_) {
    report.flipped.push_back({flip.key, flip.from, flip.to, report.objectives.size() - 1});
  }
  return !flips_.empty();
}

/// Gives the hybrid factors of a discrete variable the components that the assignment chooses.
void IncrementalSmoother::choose_components(Key key) {
  for (int f : discrete_.factors_of(key)) {
    const int t = discrete_.owner(f);
    if (t >= 0 && terms_[t].alive) set_component(t, terms_[t].hybrid->given(assignment()));
  }
}

/// Brings the flips of the last discrete half-step into the tree, or takes them back where the
/// system would be singular with them.
bool IncrementalSmoother::take_flips(UpdateReport& report) {
  if (eliminate(report)) return true;
  for (const DiscreteHalf::Flip& flip : flips_) discrete_.move(flip.key, flip.from);
  for (const DiscreteHalf::Flip& flip : flips_) choose_components(flip.key);
  const std::string reason = report.message;
  report.status = UpdateReport::Status::kOk;
  if (!eliminate(report)) return false;
  report.message =
      reason + " in the mode that its discrete variables prefer; they were left as they were";
  report.objectives.pop_back();
  report.flips -= static_cast<int>(flips_.size());
  report.flipped.resize(report.flipped.size() - flips_.size());
  return false;
}

/// Tables of hybrid factors whose variables have moved.
void IncrementalSmoother::refresh_tables() {
  sort_unique(stale_);
  std::vector<const double*> x;
  for (int t : stale_) {
    if (t >= terms_.count()) continue;
    const Term& term = terms_[t];
    if (!term.alive || term.hybrid == nullptr) continue;
    x.clear();
    for (int slot : term.slots) x.push_back(values().data(slot));
    discrete_.set_tables(table_of_term_[t], term.hybrid->given(x.data()));
  }
  stale_.clear();
}

bool IncrementalSmoother::eliminate(UpdateReport& report) {
  behind_.clear();
  for (Key key : kept_last_) {
    if (values().contains(key)) behind_.push_back(values().slot(key));
  }
  linearize_eliminated();
  const MapOf map(*this);
  const EliminationReport done = tree_.eliminate(
      last_, [this](const std::vector<int>& slots) { return is_determined(slots); }, behind_,
      map.charts());
  report.eliminated += done.variables;
  report.cliques += done.cliques;
  if (done.singular < 0) return true;
  report.status = UpdateReport::Status::kSingular;
  report.under_constrained = values().key(done.singular);
  report.message = "the factors do not determine " + to_string(report.under_constrained) +
                   "; give it a prior or more measurements";
  return false;
}

UpdateReport IncrementalSmoother::keep_last(const std::vector<Key>& keys) {
  return all_or_nothing([&](UpdateReport& report) {
    kept_last_ = keys;
    for (Key key : keys) {
      if (values().contains(key) && !estimate_.is_removed(key)) {
        tree_.eliminate_again(values().slot(key));
      }
    }
    eliminate(report);
  });
}

IncrementalSmoother::Snapshot IncrementalSmoother::snapshot() const {
  Snapshot all;
  for (int slot = 0; slot < values().slot_count(); ++slot) {
    if (!values().occupied(slot)) continue;
    const double* x = values().data(slot);
    all.keys.push_back(values().key(slot));
    all.numbers.insert(all.numbers.end(), x, x + values().type(slot).size);
  }
  return all;
}

UpdateReport IncrementalSmoother::restore(const Snapshot& snapshot) {
  std::size_t size = 0, count = 0;
  bool same = true;
  for (int slot = 0; slot < values().slot_count(); ++slot) {
    if (!values().occupied(slot)) continue;
    same = same && count < snapshot.keys.size() && snapshot.keys[count] == values().key(slot);
    size += values().type(slot).size;
    ++count;
  }
  if (!same || count != snapshot.keys.size() || size != snapshot.numbers.size()) {
    throw Error("a snapshot of other variables cannot be restored");
  }
  return all_or_nothing([&](UpdateReport& report) {
    std::vector<int> slots;
    const double* x = snapshot.numbers.data();
    for (int slot = 0; slot < values().slot_count(); ++slot) {
      if (!values().occupied(slot)) continue;
      const int n = values().type(slot).size;
      if (!std::equal(x, x + n, values().data(slot))) {
        std::copy(x, x + n, estimate_.edit(slot));
        slots.push_back(slot);
      }
      x += n;
    }
    touch(slots);
    make_models_again(touched_, report);
    if (eliminate(report)) refresh_costs(slots);
  });
}

std::vector<Key> IncrementalSmoother::elimination_order() const {
  std::vector<Key> order;
  for (int slot : tree_.order()) order.push_back(values().key(slot));
  return order;
}

}  // namespace hybrid
