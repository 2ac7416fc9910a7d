// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, the hybrid mapping authors
#include "libhybrid/smoother/window.h"

#include <algorithm>
#include <cmath>
#include <exception>
#include <map>
#include <utility>
#include <vector>

#include "libhybrid/core/sort_unique.h"
#include "libhybrid/discrete/inference.h"
#include "libhybrid/factors/linear_prior.h"
#include "libhybrid/smoother/incremental.h"
#include "libhybrid/smoother/window_tables.h"

namespace hybrid {
namespace {

/// Discrete variables that leave at their values.
struct FixedVariables {
  Assignment values;
  std::map<Key, Table> posterior;  ///< -log p of each, zero at its value
  double divergence = 0.0;
};

/// Fixes discrete variables at their values. The remaining joint density is then the conditional
/// one, whose Kullback-Leibler divergence from the joint density is -log p of the values.
FixedVariables fix(const std::vector<Key>& discrete, const IncrementalSmoother& smoother) {
  FixedVariables fixed;
  for (Key key : discrete) fixed.values.set(key, smoother.assignment().at(key));
  for (Key key : discrete) {
    if (fixed.posterior.count(key) != 0) continue;
    const std::vector<const Table*> tables = smoother.component(key);
    const DiscreteMarginals marginals = discrete_marginals(tables);
    std::vector<Table> conditioned;
    for (const Table* table : tables) conditioned.push_back(condition(*table, fixed.values));
    std::vector<const Table*> rest;
    for (const Table& table : conditioned) rest.push_back(&table);
    fixed.divergence += marginals.log_partition() - discrete_marginals(rest).log_partition();
    for (Key own : discrete) {
      if (!marginals.contains(own)) continue;
      const auto p = marginals.at(own);
      const int value = fixed.values.at(own);
      std::vector<double> costs;
      for (double share : p) costs.push_back(std::log(p[value]) - std::log(share));
      fixed.posterior[own] = Table({{own, static_cast<int>(p.size())}}, std::move(costs));
    }
  }
  return fixed;
}

/// Replaces the tables that tie fixed variables to others by what they say of those; what breaks
/// leave out counts in the objective as it is.
void condition_on(const FixedVariables& fixed, const std::vector<Handle>& breaks,
                  const IncrementalSmoother& smoother, const WindowTables& tables, Delta& change) {
  const HybridGraph& graph = smoother.graph();
  double constant = 0.0;
  for (Handle handle : breaks) {
    constant += handle.kind == FactorKind::kHybrid
                    ? graph.hybrid().at(handle)->cost(smoother.values(), smoother.assignment())
                    : graph.continuous().at(handle)->cost(smoother.values()) +
                          graph.continuous().at(handle)->log_normalizer();
  }
  for (const auto& [key, table] : fixed.posterior) {
    for (Handle handle : tables.holders(key)) {
      if (handle.kind != FactorKind::kDiscrete || !graph.contains(handle)) continue;
      const Table& tie = graph.discrete().at(handle);
      const bool counted =
          std::find(change.remove.begin(), change.remove.end(), handle) != change.remove.end();
      if (tie.keys().size() < 2 || counted) continue;
      change.remove.push_back(handle);
      Table left = condition(tie, fixed.values);
      if (left.keys().empty()) {
        constant += left.costs()[0];
      } else {
        change.discrete.push_back(std::move(left));
      }
    }
  }
  add_constant(constant, change);
}

/// The poses and points that a prior ties to each other.
std::vector<Key> tied_by(const Delta& delta) {
  std::vector<Key> tied;
  for (const ContinuousFactorPtr& factor : delta.continuous) {
    const auto* prior = dynamic_cast<const LinearPrior*>(factor.get());
    if (prior == nullptr) continue;
    for (std::size_t i = 0; i < prior->keys().size(); ++i) {
      if (prior->located()[i]) tied.push_back(prior->keys()[i]);
    }
  }
  return tied;
}

}  // namespace

/// A change of the graph by which variables leave.
struct WindowSmoother::Change {
  Marginalization made;
  FixedVariables fixed;
  std::vector<std::pair<Key, Table>> settled;  // discrete variables that leave
};

WindowReport WindowSmoother::propose(const Proposal& proposal) {
  WindowReport report;
  UpdateReport& done = report;
  if (is_full()) {
    done = hybrid::propose(smoother_, proposal);
    return report;
  }
  const Delta change = past_.with_returning(proposal.delta);
  done = hybrid::propose(smoother_, {change, proposal.allowed_rise, proposal.moved});
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
  const Delta change = past_.with_returning(delta);
  done = smoother_.update(change);
  if (done.status != UpdateReport::Status::kOk) return report;
  take_in(delta, change, done);
  if (is_bounded()) {
    for (const Departure& going : chain_.surplus(smoother_, held_)) {
      if (!leave(going, report) || !going.anchor) continue;
      if (const auto other = chain_.absorption(*going.anchor, smoother_)) leave(*other, report);
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

/// Notes an update that the graph has taken: `change` is `delta` with what enters again, which is
/// no longer past.
void WindowSmoother::take_in(const Delta& delta, const Delta& change, UpdateReport& report) {
  ++updates_;
  for (Key key : change.values.keys()) {
    last_touch_[key] = updates_;
    if (is_bounded() && window_.is_state(key, change.values.type(key))) chain_.enter(key);
  }
  std::vector<Handle>& tables = report.handles.discrete;
  for (std::size_t recalled = delta.discrete.size(); recalled < tables.size(); ++recalled) {
    const Key key = smoother_.graph().discrete().at(tables[recalled]).keys()[0].key;
    tables_.enter(key, tables[recalled]);
  }
  tables.resize(delta.discrete.size());
  past_.forget_returned(delta, change);
  touch(delta, report.handles);
}

void WindowSmoother::touch(const Delta& delta, const AddedHandles& handles) {
  for (Key key : delta.remove_values) last_touch_.erase(key);
  chain_.forget(delta.remove_values);
  const HybridGraph& graph = smoother_.graph();
  tables_.enter(handles, graph);
  for (Handle handle : handles.continuous) {
    for (Key key : graph.continuous().at(handle)->keys()) last_touch_[key] = updates_;
  }
  for (Handle handle : handles.hybrid) {
    for (Key key : graph.hybrid().at(handle)->keys()) last_touch_[key] = updates_;
  }
}

/// The variables that leave the window now, in a fixed order.
std::vector<Key> WindowSmoother::outdated(const Delta& delta) const {
  std::vector<Key> keys;
  const bool filter = window_.mode == WindowOptions::Mode::kFilter;
  if (!filter && window_.lag <= 0) return keys;
  bool new_state = false;
  for (Key key : delta.values.keys()) {
    new_state = new_state || window_.is_state(key, delta.values.type(key));
  }
  for (const auto& [key, update] : last_touch_) {
    if (window_.is_lasting(key) || held_.count(key) != 0) continue;
    if (!filter && update <= updates_ - window_.lag) keys.push_back(key);
    if (filter && new_state && window_.is_state(key, smoother_.values().type(key)) &&
        !delta.values.contains(key)) {
      keys.push_back(key);
    }
  }
  sort_unique(keys);
  return keys;
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

/// The change of the graph by which variables leave.
WindowSmoother::Change WindowSmoother::change_of(const Departure& going) {
  const HybridGraph& graph = smoother_.graph();
  const std::vector<Handle> factors = factors_of(going);
  std::vector<Handle> all = factors;
  all.insert(all.end(), going.breaks.begin(), going.breaks.end());
  std::vector<Key> discrete;
  for (Handle handle : all) {
    if (handle.kind != FactorKind::kHybrid) continue;
    for (const DiscreteKey& d : graph.hybrid().at(handle)->discrete_keys())
      discrete.push_back(d.key);
  }
  sort_unique(discrete);
  Change change;
  if (is_bounded()) change.fixed = fix(tables_.chosen_by(all, graph, discrete), smoother_);
  const Assignment& fixed = change.fixed.values;
  change.made = marginalize(
      graph, smoother_.values(), smoother_.assignment(), going.keys, factors,
      [&](Key key) { return !fixed.contains(key) && tables_.is_tied(key, graph, all); });
  if (!change.made.finite) return change;
  Delta& delta = change.made.delta;
  delta.remove.insert(delta.remove.end(), going.breaks.begin(), going.breaks.end());
  if (is_bounded()) condition_on(change.fixed, going.breaks, smoother_, tables_, delta);
  for (Key key : discrete) {
    if (auto table = tables_.settle(key, graph, delta))
      change.settled.emplace_back(key, std::move(*table));
  }
  tables_.settle_constant(graph, smoother_.assignment(), change.settled, delta);
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
    past_.leave(key, before.values.type(key), before.values.data(key));
    last_touch_.erase(key);
    report.left.push_back(key);
  }
  for (auto& [key, table] : change.settled) {
    const auto posterior = change.fixed.posterior.find(key);
    if (posterior != change.fixed.posterior.end()) table = posterior->second;
    past_.leave(key, before.assignment.at(key), std::move(table));
    tables_.forget(key);
    report.left_discrete.push_back(key);
  }
  tables_.take(done.handles.discrete, smoother_.graph());
  const auto& open = change.made.undetermined;
  report.undetermined.insert(report.undetermined.end(), open.begin(), open.end());
  report.marginalized += static_cast<int>(keys.size());
  report.fill += change.made.fill;
  report.seconds += done.seconds;
  report.changed.insert(report.changed.end(), done.changed.begin(), done.changed.end());
  report.objective_after = done.objective_after;
  if (!is_bounded()) return true;
  past_.leave(keys, covariance, std::move(places));
  note_departure(going, change.fixed.divergence, report);
  return true;
}

void WindowSmoother::note_departure(const Departure& gone, double fixed, WindowReport& report) {
  chain_.leave(gone);
  if (gone.anchor) {
    ++report.breaks;
    ++breaks_;
  }
  report.divergence += fixed + gone.loss;
  divergence_ += fixed + gone.loss;
}

}  // namespace hybrid
