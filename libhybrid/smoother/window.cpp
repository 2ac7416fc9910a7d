// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, the hybrid mapping authors
#include "libhybrid/smoother/window.h"

#include <algorithm>
#include <exception>
#include <utility>

#include "libhybrid/core/detail/sort_unique.h"

namespace hybrid {
namespace {

bool names(const std::string& letters, Key key) {
  return letters.find(key.letter()) != std::string::npos;
}

/// Sum of two tables over one and the same variable; an empty one counts as zero.
Table sum(const Table& a, const Table& b) {
  if (a.keys().empty()) return b;
  std::vector<double> costs = a.costs();
  for (std::size_t i = 0; i < costs.size(); ++i) costs[i] += b.costs()[i];
  return {a.keys(), std::move(costs)};
}

}  // namespace

const Table* WindowSmoother::past_table(Key key) const {
  const auto it = past_tables_.find(key);
  return it == past_tables_.end() ? nullptr : &it->second;
}

WindowReport WindowSmoother::propose(const Proposal& proposal) {
  WindowReport report;
  UpdateReport& done = report;
  if (is_full()) {
    done = hybrid::propose(smoother_, proposal);
    return report;
  }
  const Delta change = with_returning(proposal.delta);
  done = hybrid::propose(smoother_, {change, proposal.allowed_rise});
  if (done.status == UpdateReport::Status::kOk) take_in(proposal.delta, change, done);
  return report;
}

WindowReport WindowSmoother::update(const Delta& delta) {
  WindowReport report;
  UpdateReport& done = report;
  if (is_full()) {
    done = smoother_.update(delta);
    return report;
  }
  const Delta change = with_returning(delta);
  done = smoother_.update(change);
  if (done.status != UpdateReport::Status::kOk) return report;
  take_in(delta, change, done);
  if (is_bounded()) {
    for (const Departure& going : surplus()) {
      if (leave(going, report) && going.anchor) absorb(*going.anchor, report);
    }
    return report;
  }
  const std::vector<Key> keys = outdated(delta);
  if (!keys.empty()) leave({keys}, report);
  return report;
}

UpdateReport WindowSmoother::converge_from(const Values& start) {
  IncrementalSmoother::Snapshot place = smoother_.snapshot();
  auto x = place.numbers.begin();
  for (const Key key : place.keys) x = std::copy_n(start.data(key), start.type(key).size, x);
  const double before = smoother_.objective();
  smoother_.begin();
  UpdateReport report = smoother_.restore(place);
  if (report.status != UpdateReport::Status::kOk) return {};
  report = smoother_.converge();
  if (report.status != UpdateReport::Status::kOk) return {};
  if (!(smoother_.objective() < before)) {
    smoother_.roll_back();
    return {};
  }
  smoother_.commit();
  report.objective_before = before;
  report.objectives = {smoother_.objective()};  // the way there led over higher ones
  for (Flip& flip : report.flipped) flip.half_step = 0;
  return report;
}

/// The change with those variables that its factors hold although they have left; the tables of
/// discrete ones come last.
Delta WindowSmoother::with_returning(const Delta& delta) const {
  Delta out = delta;
  const auto recall = [&](const std::vector<Key>& keys) {
    for (Key key : keys) {
      if (out.values.contains(key) || !past_.values.contains(key)) continue;
      out.values.insert(key, past_.values.type(key), past_.values.data(key));
    }
  };
  std::vector<Key> recalled;
  const auto recall_discrete = [&](const std::vector<DiscreteKey>& keys) {
    for (const DiscreteKey& key : keys) {
      if (!past_.assignment.contains(key.key)) continue;
      if (std::find(recalled.begin(), recalled.end(), key.key) != recalled.end()) continue;
      recalled.push_back(key.key);
      out.assignment.set(key.key, past_.assignment.at(key.key));
      if (const Table* table = past_table(key.key)) out.discrete.push_back(*table);
    }
  };
  for (const ContinuousFactorPtr& factor : delta.continuous) {
    if (factor != nullptr) recall(factor->keys());
  }
  for (const Table& table : delta.discrete) recall_discrete(table.keys());
  for (const HybridFactorPtr& factor : delta.hybrid) {
    if (factor == nullptr) continue;
    recall(factor->keys());
    recall_discrete(factor->discrete_keys());
  }
  return out;
}

/// Notes an update that the graph has taken: `change` is `delta` with what enters again, which is
/// no longer past.
void WindowSmoother::take_in(const Delta& delta, const Delta& change, UpdateReport& report) {
  ++updates_;
  for (Key key : change.values.keys()) {
    last_touch_[key] = updates_;
    if (past_.values.contains(key)) past_.values.erase(key);
    if (is_bounded() && is_state(key, change.values.type(key))) enter_state(key);
  }
  std::vector<Handle>& tables = report.handles.discrete;
  for (std::size_t recalled = delta.discrete.size(); recalled < tables.size(); ++recalled) {
    const Key key = smoother_.graph().discrete().at(tables[recalled]).keys()[0].key;
    holders_[key].push_back(tables[recalled]);
  }
  tables.resize(delta.discrete.size());
  const auto forget = [&](const std::vector<DiscreteKey>& keys) {
    for (const DiscreteKey& key : keys) {
      past_.assignment.erase(key.key);
      past_tables_.erase(key.key);
    }
  };
  for (const Table& table : delta.discrete) forget(table.keys());
  for (const HybridFactorPtr& factor : delta.hybrid) forget(factor->discrete_keys());
  touch(delta, report.handles);
}

void WindowSmoother::touch(const Delta& delta, const AddedHandles& handles) {
  for (Key key : delta.remove_values) last_touch_.erase(key);
  forget_states(delta.remove_values);
  const HybridGraph& graph = smoother_.graph();
  const auto hold = [&](const std::vector<DiscreteKey>& keys, Handle handle) {
    for (const DiscreteKey& key : keys) holders_[key.key].push_back(handle);
  };
  for (Handle handle : handles.continuous) {
    for (Key key : graph.continuous().at(handle)->keys()) last_touch_[key] = updates_;
  }
  for (Handle handle : handles.discrete) hold(graph.discrete().at(handle).keys(), handle);
  for (Handle handle : handles.hybrid) {
    const HybridFactor& factor = *graph.hybrid().at(handle);
    for (Key key : factor.keys()) last_touch_[key] = updates_;
    hold(factor.discrete_keys(), handle);
  }
}

bool WindowSmoother::is_state(Key key, VariableType type) const {
  if (names(window_.lasting, key)) return false;
  if (!window_.states.empty()) return names(window_.states, key);
  return is_pose(type);
}

/// The variables that leave the window now, in a fixed order.
std::vector<Key> WindowSmoother::outdated(const Delta& delta) const {
  std::vector<Key> keys;
  const bool filter = window_.mode == WindowOptions::Mode::kFilter;
  if (!filter && window_.lag <= 0) return keys;
  bool new_state = false;
  for (Key key : delta.values.keys()) {
    new_state = new_state || is_state(key, delta.values.type(key));
  }
  for (const auto& [key, update] : last_touch_) {
    if (names(window_.lasting, key) || held_.count(key) != 0) continue;
    if (!filter && update <= updates_ - window_.lag) keys.push_back(key);
    if (filter && new_state && is_state(key, smoother_.values().type(key)) &&
        !delta.values.contains(key)) {
      keys.push_back(key);
    }
  }
  sort_unique(keys);
  return keys;
}

/// A discrete variable that a change leaves with nothing but tables of its own goes too: the change
/// then removes them, and their sum is returned (empty without tables). Of a variable that stays,
/// the table that the change adds takes in the one of earlier changes, so that their number does
/// not grow.
std::optional<Table> WindowSmoother::settle(Key key, Delta& delta) {
  const HybridGraph& graph = smoother_.graph();
  std::vector<Handle>& holders = holders_[key];
  const auto dead = [&](Handle handle) { return !graph.contains(handle); };
  holders.erase(std::remove_if(holders.begin(), holders.end(), dead), holders.end());
  std::vector<Handle> staying;
  for (Handle handle : holders) {
    if (std::find(delta.remove.begin(), delta.remove.end(), handle) == delta.remove.end())
      staying.push_back(handle);
  }
  const auto its_own = [&](const Table& table) {
    return table.keys().size() == 1 && table.keys()[0].key == key;
  };
  const auto holds = [&](const Table& table) {
    return std::any_of(table.keys().begin(), table.keys().end(),
                       [&](const DiscreteKey& other) { return other.key == key; });
  };
  const bool leaves = std::all_of(staying.begin(), staying.end(),
                                  [&](Handle handle) {
                                    return handle.kind == FactorKind::kDiscrete &&
                                           its_own(graph.discrete().at(handle));
                                  }) &&
                      std::none_of(delta.discrete.begin(), delta.discrete.end(),
                                   [&](const Table& t) { return holds(t) && !its_own(t); });
  const auto added = std::find_if(delta.discrete.begin(), delta.discrete.end(), its_own);
  if (!leaves) {
    const auto before = table_.find(key);
    if (added == delta.discrete.end() || before == table_.end()) return std::nullopt;
    *added = sum(*added, graph.discrete().at(before->second));
    delta.remove.push_back(before->second);
    return std::nullopt;
  }
  Table total;
  if (added != delta.discrete.end()) {
    total = *added;
    delta.discrete.erase(added);
  }
  for (Handle handle : staying) {
    total = sum(total, graph.discrete().at(handle));
    delta.remove.push_back(handle);
  }
  return total;
}

/// Whether a discrete variable shares a table with others, beside the factors that go.
bool WindowSmoother::is_tied(Key key, const std::vector<Handle>& going) const {
  const auto it = holders_.find(key);
  if (it == holders_.end()) return false;
  const HybridGraph& graph = smoother_.graph();
  return std::any_of(it->second.begin(), it->second.end(), [&](Handle handle) {
    return handle.kind == FactorKind::kDiscrete && graph.contains(handle) &&
           graph.discrete().at(handle).keys().size() > 1 &&
           std::find(going.begin(), going.end(), handle) == going.end();
  });
}

/// Lets variables leave together, or else those of them that can, one by one: what holds one back
/// must not hold back the others, or the window would grow without bound. The update proper has
/// been made: where a factor throws, its variables stay for now.
bool WindowSmoother::leave(const Departure& going, WindowReport& report) {
  const auto leaves = [&](const Departure& some) {
    try {
      return try_to_leave(some, report);
    } catch (const std::exception& error) {
      report.kept_because = error.what();
      return false;
    }
  };
  if (leaves(going)) return true;
  for (Key key : going.keys) {
    if (going.keys.size() == 1 || !leaves({{key}})) report.kept.push_back(key);
  }
  if (report.kept.empty()) report.kept_because.clear();
  return false;
}

/// The factors that become a prior.
std::vector<Handle> WindowSmoother::factors_of(const Departure& going) const {
  std::vector<Handle> factors = going.absorbed;
  const auto is_in = [](const std::vector<Handle>& list, Handle handle) {
    return std::find(list.begin(), list.end(), handle) != list.end();
  };
  for (Key key : going.keys) {
    for (Handle handle : smoother_.factors_of(key)) {
      if (!is_in(factors, handle) && !is_in(going.breaks, handle)) factors.push_back(handle);
    }
  }
  return factors;
}

/// Gathers what the objective keeps of all that has left in one table over no variable: that of the
/// change, that of earlier changes, and the last costs of discrete variables that leave.
void WindowSmoother::settle_constant(std::vector<std::pair<Key, Table>>& settled, Delta& delta) {
  double constant = 0.0;
  for (auto& [key, table] : settled) {
    if (table.keys().empty()) continue;
    const double last = table.cost(smoother_.assignment());
    std::vector<double> costs = table.costs();
    for (double& cost : costs) cost -= last;
    table = Table(table.keys(), std::move(costs));
    constant += last;
  }
  if (constant_) {
    constant += smoother_.graph().discrete().at(*constant_).costs()[0];
    delta.remove.push_back(*constant_);
  }
  add_constant(constant, delta);
}

/// Adds to the table over no variable, of which a change has one.
void WindowSmoother::add_constant(double constant, Delta& delta) {
  for (Table& table : delta.discrete) {
    if (table.keys().empty()) table = Table({}, {table.costs()[0] + constant});
  }
}

/// The change of the graph by which variables leave.
WindowSmoother::Change WindowSmoother::change_of(const Departure& going) {
  const HybridGraph& graph = smoother_.graph();
  const std::vector<Handle> factors = factors_of(going);
  std::vector<Handle> all = factors;
  all.insert(all.end(), going.breaks.begin(), going.breaks.end());
  Change change;
  for (Handle handle : all) {
    if (handle.kind != FactorKind::kHybrid) continue;
    for (const DiscreteKey& d : graph.hybrid().at(handle)->discrete_keys())
      change.discrete.push_back(d.key);
  }
  sort_unique(change.discrete);
  if (is_bounded()) change.fixed = fix(chosen_by(all, change.discrete));
  const Assignment& fixed = change.fixed.values;
  change.made = marginalize(graph, smoother_.values(), smoother_.assignment(), going.keys, factors,
                            [&](Key key) { return !fixed.contains(key) && is_tied(key, all); });
  if (!change.made.finite) return change;
  Delta& delta = change.made.delta;
  delta.remove.insert(delta.remove.end(), going.breaks.begin(), going.breaks.end());
  if (is_bounded()) hold(change.fixed, going.breaks, delta);
  for (Key key : change.discrete) {
    if (auto table = settle(key, delta)) change.settled.emplace_back(key, std::move(*table));
  }
  settle_constant(change.settled, delta);
  return change;
}

bool WindowSmoother::try_to_leave(const Departure& going, WindowReport& report) {
  const std::vector<Key>& keys = going.keys;
  Change change = change_of(going);
  if (!change.made.finite) {
    report.kept_because = "a factor has no finite derivative at the estimate";
    return false;
  }
  Estimate before;
  for (Key key : keys)
    before.values.insert(key, smoother_.values().type(key), smoother_.values().data(key));
  for (const auto& [key, table] : change.settled)
    before.assignment.set(key, smoother_.assignment().at(key));
  const Eigen::MatrixXd covariance =
      is_bounded() ? smoother_.joint_covariance(keys) : Eigen::MatrixXd();
  PastStates::Departure places;
  if (is_bounded()) places = {change.made, tied_by(change.made.delta), smoother_.values()};
  const UpdateReport done = smoother_.update(change.made.delta);
  if (done.status != UpdateReport::Status::kOk) {
    report.kept_because = done.message;
    return false;
  }
  for (Key key : keys) {
    past_.values.insert(key, before.values.type(key), before.values.data(key));
    last_touch_.erase(key);
    report.left.push_back(key);
  }
  for (auto& [key, table] : change.settled) {
    past_.assignment.set(key, before.assignment.at(key));
    const auto posterior = change.fixed.posterior.find(key);
    if (posterior != change.fixed.posterior.end()) table = posterior->second;
    if (!table.keys().empty()) past_tables_[key] = std::move(table);
    holders_.erase(key);
    table_.erase(key);
    report.left_discrete.push_back(key);
  }
  take_tables(done.handles.discrete);
  const auto& open = change.made.undetermined;
  report.undetermined.insert(report.undetermined.end(), open.begin(), open.end());
  report.marginalized += static_cast<int>(keys.size());
  report.fill += change.made.fill;
  report.seconds += done.seconds;
  report.changed.insert(report.changed.end(), done.changed.begin(), done.changed.end());
  report.objective_after = done.objective_after;
  if (is_bounded()) note_departure(going, change.fixed, covariance, report);
  if (is_bounded()) past_states_.leave(std::move(places));
  return true;
}

/// Remembers the tables that marginalisation has left.
void WindowSmoother::take_tables(const std::vector<Handle>& tables) {
  for (Handle handle : tables) {
    const Table& table = smoother_.graph().discrete().at(handle);
    if (table.keys().empty()) constant_ = handle;
    for (const DiscreteKey& key : table.keys()) holders_[key.key].push_back(handle);
    if (table.keys().size() == 1) table_[table.keys()[0].key] = handle;
  }
}

}  // namespace hybrid
