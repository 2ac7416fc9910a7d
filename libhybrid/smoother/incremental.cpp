// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, the hybrid mapping authors
#include "libhybrid/smoother/incremental.h"

#include <algorithm>
#include <chrono>
#include <cmath>
#include <set>
#include <string>
#include <utility>

#include "libhybrid/core/elapsed.h"
#include "libhybrid/discrete/impossible.h"
#include "libhybrid/marginals/continuous.h"
#include "libhybrid/smoother/detail/step_control.h"

namespace hybrid {
namespace {

/// What is too little for an update to matter, in units of the objective: the next ones go on.
constexpr double kMinorGain = 1.0;

/// What `settle` may leave undone, as a share of what updates may: where decisions compare
/// objectives, it must be far below what decides.
constexpr double kSettled = 1e-2;

/// Throws Error that names variables of which no joint value is possible, if there are any.
void refuse_impossible(const DiscreteHalf& half, const DiscreteOptions& options) {
  std::set<Key> left;
  for (const auto& [key, value] : half.assignment()) left.insert(key);
  while (!left.empty()) {
    const std::vector<const Table*> tables = half.component(*left.begin());
    left.erase(left.begin());
    for (const Table* table : tables) {
      for (const DiscreteKey& key : table->keys()) left.erase(key.key);
    }
    const DiscreteSolution solved = solve_discrete(tables, options, &half.assignment());
    if (!solved.impossible.empty()) throw Error(no_joint_value(solved.impossible));
  }
}

}  // namespace

/// Runs change(report), which makes the smoother what it will be. Where it throws, or leaves a
/// status other than kOk, all is taken back, or what came since the newest mark.
template <class Change>
UpdateReport IncrementalSmoother::all_or_nothing(const Change& change) {
  const auto start = std::chrono::steady_clock::now();
  const bool own = !in_transaction();
  UpdateReport report;
  report.objective_before = objective();
  state_.start_change();
  try {
    change(report);
    if (report.status == UpdateReport::Status::kOk && !std::isfinite(objective())) {
      state_.refresh_tables();
      refuse_impossible(state_.discrete(), options_.discrete);
    }
    if (report.status == UpdateReport::Status::kOk) report.changed = state_.changed();
  } catch (...) {
    state_.undo_failed();
    throw;
  }
  if (report.status != UpdateReport::Status::kOk) {
    state_.undo_failed();
    report.handles = {};
  } else if (own) {
    state_.commit(options_.recent);
  }
  report.pending = tree().pending();
  report.objective_after = objective();
  report.seconds = seconds_since(start);
  return report;
}

// Algorithm (section IV-B): D given C for what was touched; then rounds of C given D and D given C.
UpdateReport IncrementalSmoother::update(const Delta& delta) {
  return update(delta, usual_leeway());
}

Leeway IncrementalSmoother::usual_leeway() const {
  return {options_.relinearize, options_.wildfire, options_.bend,
          options_.bend_share,  kMinorGain,        options_.defer};
}

UpdateReport IncrementalSmoother::update(const Delta& delta, const Leeway& leeway) {
  return all_or_nothing([&](UpdateReport& report) {
    continuous().set_leeway(leeway);
    state_.check(delta);
    report.handles = state_.stage(delta);
    record(report);
    report.objective_before = objective();
    discrete_step(report);
    state_.enter_tree(report.handles);
    continuous().renew_off(report);
    if (continuous().eliminate_new(state_.given(), report)) alternate(report);
  });
}

/// Alternates until nothing flips and linear models are off by little in all, or for the rounds
/// that an update may take: a large innovation outruns the models of many factors at once.
void IncrementalSmoother::alternate(UpdateReport& report) {
  for (bool goes_on = true; goes_on;) {
    continuous_step(report);
    if (report.status != UpdateReport::Status::kOk) return;
    goes_on = take_discrete_step(report);
    if (report.rounds >= options_.rounds) break;
    if (!goes_on && continuous().costs().open() > continuous().leeway().minor) {
      goes_on = renew_models(report);
    }
  }
  report.open = continuous().costs().open();
}

void IncrementalSmoother::continuous_step(UpdateReport& report) {
  StepControl(continuous(), state_.given(), report).run();
  record(report);
}

/// Makes those linear models again that are off. Returns whether there were any.
bool IncrementalSmoother::renew_models(UpdateReport& report) {
  if (!continuous().costs().any_off()) return false;
  continuous().renew_off(report);
  if (continuous().eliminate(state_.given(), report)) return true;
  report.status = UpdateReport::Status::kOk;
  return false;
}

UpdateReport IncrementalSmoother::settle(int max_updates) {
  Leeway fine = usual_leeway();
  for (double* of :
       {&fine.relinearize, &fine.wildfire, &fine.bend, &fine.bend_share, &fine.minor}) {
    *of *= kSettled;
  }
  continuous().set_leeway(fine);
  continuous().choose_off();
  UpdateReport report;
  report.objective_before = report.objective_after = objective();
  int idle = 0;  // updates in a row that brought nothing
  for (int k = 0; k < max_updates; ++k) {
    const double before = objective();
    const UpdateReport one = update({}, fine);
    report.go_on(one);
    if (one.status != UpdateReport::Status::kOk) break;
    idle = one.flips == 0 && before - objective() <= fine.minor ? idle + 1 : 0;
    // One that took its step back made linear models that the next one begins with.
    if (idle > (one.open > fine.minor ? 1 : 0)) break;
  }
  return report;
}

UpdateReport IncrementalSmoother::converge(int max_rounds, double tolerance) {
  if (!(tolerance >= 0.0)) {
    throw Error("the tolerance of converge must not be negative, got " + std::to_string(tolerance));
  }
  return all_or_nothing([&](UpdateReport& report) {
    while (report.rounds < max_rounds) {
      const double before = objective();
      continuous().models().enter_pulls(values());
      continuous().renew_all(report);
      if (!continuous().eliminate(state_.given(), report)) return;
      const double bend = tolerance * std::max(1.0, std::abs(before));
      continuous().set_leeway({options_.relinearize, 0.0, 0.0, bend});
      continuous_step(report);
      if (report.status != UpdateReport::Status::kOk) return;
      const bool flipped = take_discrete_step(report);
      const double decrease = before - objective();
      if (!flipped && decrease <= tolerance * std::max(1.0, std::abs(before))) return;
    }
  });
}

double IncrementalSmoother::cost() const {
  return hybrid::cost(graph(), values(), assignment());
}

/// Solves the touched discrete components (eq. 8a) and changes the components of hybrid factors
/// that follow. Returns what flipped.
std::vector<DiscreteHalf::Flip> IncrementalSmoother::discrete_step(UpdateReport& report) {
  state_.refresh_tables();
  DiscreteHalf::Report done = state_.discrete().solve(options_.discrete);
  report.components += done.components;
  report.exact = report.exact && done.exact;
  report.flips += static_cast<int>(done.flips.size());
  for (const DiscreteHalf::Flip& flip : done.flips) state_.choose_components(flip.key);
  if (!done.flips.empty()) record(report);
  for (const DiscreteHalf::Flip& flip : done.flips) {
    report.flipped.push_back({flip.key, flip.from, flip.to, report.objectives.size() - 1});
  }
  return std::move(done.flips);
}

/// Takes a discrete half-step and brings what flipped into the tree, or takes it back where the
/// system would be singular with it. Returns whether anything flipped for good.
bool IncrementalSmoother::take_discrete_step(UpdateReport& report) {
  const std::vector<DiscreteHalf::Flip> flips = discrete_step(report);
  if (flips.empty()) return false;
  if (continuous().eliminate(state_.given(), report)) return true;
  for (const DiscreteHalf::Flip& flip : flips) state_.discrete().move(flip.key, flip.from);
  for (const DiscreteHalf::Flip& flip : flips) state_.choose_components(flip.key);
  const std::string reason = report.message;
  report.status = UpdateReport::Status::kOk;
  if (!continuous().eliminate(state_.given(), report)) return false;
  report.message =
      reason + " in the mode that its discrete variables prefer; they were left as they were";
  report.objectives.pop_back();
  report.flips -= static_cast<int>(flips.size());
  report.flipped.resize(report.flipped.size() - flips.size());
  return false;
}

UpdateReport IncrementalSmoother::keep_last(const std::vector<Key>& keys) {
  return all_or_nothing([&](UpdateReport& report) {
    continuous().keep_last(keys);
    continuous().eliminate(state_.given(), report);
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
  Places moved;
  const double* x = snapshot.numbers.data();
  for (int slot = 0; slot < values().slot_count(); ++slot) {
    if (!values().occupied(slot)) continue;
    const int n = values().type(slot).size;
    if (!std::equal(x, x + n, values().data(slot))) moved.append(slot, x, n);
    x += n;
  }
  return all_or_nothing(
      [&](UpdateReport& report) { continuous().jump(moved, state_.given(), report); });
}

UpdateReport IncrementalSmoother::move(const Values& to) {
  Places moved;
  for (const Key key : to.keys()) {
    const VariableType type = to.type(key);
    if (values().type(key) != type) throw Error(to_string(key) + " is no " + to_string(type));
    moved.append(values().slot(key), to.data(key), type.size);
  }
  return all_or_nothing(
      [&](UpdateReport& report) { continuous().jump(moved, state_.given(), report); });
}

std::vector<Key> IncrementalSmoother::elimination_order() const {
  std::vector<Key> order;
  for (int slot : tree().cliques().order()) order.push_back(values().key(slot));
  return order;
}

Eigen::MatrixXd IncrementalSmoother::joint_covariance(const std::vector<Key>& keys) const {
  if (continuous().models().is_whole()) return continuous().joint_covariance(keys);
  return ContinuousMarginals(graph(), estimate()).joint_covariance(keys);
}

Eigen::MatrixXd IncrementalSmoother::joint_covariance(const std::vector<Key>& keys,
                                                      const Eigen::MatrixXd& J) const {
  if (continuous().models().is_whole()) return continuous().joint_covariance(keys, J);
  return J * joint_covariance(keys) * J.transpose();
}

void IncrementalSmoother::visit_covariances(
    const std::function<void(Key, const Eigen::MatrixXd&)>& visit) const {
  if (continuous().models().is_whole()) return continuous().visit_covariances(visit);
  const Covariances all = ContinuousMarginals(graph(), estimate()).all();
  for (Key key : values().keys()) {
    if (all.contains(key)) visit(key, all.at(key));
  }
}

void IncrementalSmoother::commit() {
  if (!in_transaction()) throw Error("the smoother is in no transaction; was an update refused?");
  state_.commit(options_.recent);
}

std::vector<Handle> IncrementalSmoother::factors_of(Key key) const {
  const Terms& terms = continuous().terms();
  std::vector<Handle> handles;
  for (int t : terms.of_variable(values().slot(key))) {
    if (terms[t].alive) handles.push_back(terms[t].handle);
  }
  return handles;
}

IncrementalSmoother::Memory IncrementalSmoother::memory() const {
  Memory memory;
  memory.bytes = continuous().bytes() + state_.discrete().bytes();
  if (!values().empty()) memory.bytes_per_variable = double(memory.bytes) / double(values().size());
  return memory;
}

}  // namespace hybrid
