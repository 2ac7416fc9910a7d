// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, the hybrid mapping authors

#include "mrpt_plugins/mapping/batch_backend.h"

#include <fmt/format.h>

#include <chrono>
#include <cmath>
#include <memory>
#include <utility>

#include "libhybrid/core/elapsed.h"
#include "libhybrid/marginals/continuous.h"
#include "libhybrid/solvers/starts.h"

namespace hybrid {
namespace {

using Clock = std::chrono::steady_clock;

/// Adds the objective and cost of the new factors at the given estimate.
void add_to(const Delta& delta, const Estimate& at, double& objective, double& cost) {
  for (const ContinuousFactorPtr& factor : delta.continuous) {
    const double c = factor->cost(at.values);
    cost += c;
    objective += c + factor->log_normalizer();
  }
  for (const Table& table : delta.discrete) objective += table.cost(at.assignment);
  for (const HybridFactorPtr& factor : delta.hybrid) {
    objective += factor->cost(at.values, at.assignment);
    const Component component = factor->given(at.assignment);
    if (component.factor != nullptr) cost += component.factor->cost(at.values);
  }
}

/// Moves some variables.
void move(Values& values, const Values& to) {
  for (const Key key : to.keys()) {
    const VariableType type = to.type(key);
    if (values.type(key) != type) throw Error(to_string(key) + " is no " + to_string(type));
    std::copy_n(to.data(key), type.size, values.data(values.slot(key)));
  }
}

/// Reverts a change: the steps of its undo from the last to the first.
void revert(const std::vector<std::function<void()>>& undo) {
  for (auto step = undo.rbegin(); step != undo.rend(); ++step) (*step)();
}

}  // namespace

BatchBackend::BatchBackend(const AlternatingOptions& options, int solve_every)
    : options_(options), solve_every_(solve_every) {}

BackendReport BatchBackend::update(const Delta& delta) {
  const auto start = Clock::now();
  marginals_.reset();
  BackendReport report;
  Undo undo;
  try {
    report.handles = insert(delta, undo);
    if (solve_every_ > 0 && (updates_ + 1) % solve_every_ == 0) {
      AddedHandles handles = std::move(report.handles);
      report = solve(estimate_);
      report.handles = std::move(handles);
      ++updates_;
      return report;
    }
    if (delta.remove.empty()) {
      add_to(delta, estimate_, objective_, cost_);
    } else {
      objective_ = objective(graph_, estimate_.values, estimate_.assignment);
      cost_ = cost(graph_, estimate_.values, estimate_.assignment);
    }
    if (!std::isfinite(cost_)) throw Error("a new factor has a cost that is not finite");
  } catch (...) {
    revert(undo);
    throw;
  }
  is_solved_ = false;
  ++updates_;
  report.objective_after = objective_;
  report.cost = cost_;
  report.seconds = seconds_since(start);
  return report;
}

BackendReport BatchBackend::propose(const Proposal& proposal) {
  Undo undo;
  undo.emplace_back([this, x = estimate_, o = objective_, c = cost_, is_solved = is_solved_] {
    estimate_ = x;
    objective_ = o;
    cost_ = c;
    is_solved_ = is_solved;
    marginals_.reset();
  });
  BackendReport report;
  double settled = 0.0;
  try {
    // What earlier updates have left undone is no part of what the change is judged by.
    if (!is_solved_) report = solve(estimate_);
    settled = objective_;
    report.warnings.clear();
    move(estimate_.values, proposal.moved);
    AddedHandles handles = insert(proposal.delta, undo);
    add_work(report, solve(estimate_));
    report.handles = std::move(handles);
  } catch (...) {
    revert(undo);
    throw;
  }
  if (report.objective_after - settled <= proposal.allowed_rise) {
    ++updates_;
    return report;
  }
  revert(undo);
  BackendReport trial;
  trial.status = UpdateReport::Status::kTurnedDown;
  trial.rounds = report.rounds;
  trial.relinearized = report.relinearized;
  trial.objective_after = objective_;
  trial.cost = cost_;
  trial.seconds = report.seconds;
  return trial;
}

/// Applies a change, which revert(undo) takes back.
AddedHandles BatchBackend::insert(const Delta& delta, Undo& undo) {
  undo.emplace_back([this, o = objective_, c = cost_] {
    objective_ = o;
    cost_ = c;
  });
  for (const Handle handle : delta.remove) {
    auto removed = std::make_shared<HybridGraph::Removed>();
    undo.emplace_back([this, removed] {
      if (removed->handle.valid()) graph_.put_back(std::move(*removed));
    });
    *removed = graph_.remove(handle);
  }
  Values& values = estimate_.values;
  for (const Key key : delta.remove_values) {
    const double* x = values.data(key);
    undo.emplace_back([this, key, type = values.type(key),
                       old = std::vector<double>(x, x + values.type(key).size)] {
      if (!estimate_.values.contains(key)) estimate_.values.insert(key, type, old.data());
    });
    values.erase(key);
  }
  for (const Key key : delta.values.keys()) {
    values.insert(key, delta.values.type(key), delta.values.data(key));
    undo.emplace_back([this, key] { estimate_.values.erase(key); });
  }
  AddedHandles handles;
  const auto added = [&](Handle handle, std::vector<Handle>& list) {
    list.push_back(handle);
    undo.emplace_back([this, handle] { graph_.remove(handle); });
  };
  for (const ContinuousFactorPtr& factor : delta.continuous) {
    gather(factor->keys(), factor->types(), values);  // throws if a variable is missing
    added(graph_.add(factor), handles.continuous);
  }
  for (const Table& table : delta.discrete) {
    add_discrete(table.keys(), delta.assignment, undo);
    added(graph_.add(table), handles.discrete);
  }
  for (const HybridFactorPtr& factor : delta.hybrid) {
    gather(factor->keys(), factor->types(), values);
    add_discrete(factor->discrete_keys(), delta.assignment, undo);
    added(graph_.add(factor), handles.hybrid);
  }
  return handles;
}

/// Sets new discrete variables to their initial value. Throws Error if two factors disagree about
/// the number of values of a variable.
void BatchBackend::add_discrete(const std::vector<DiscreteKey>& keys, const Assignment& initial,
                                Undo& undo) {
  for (const DiscreteKey& key : keys) {
    const int known = cardinalities_.emplace(key.key, key.cardinality).first->second;
    if (known != key.cardinality) {
      throw Error(
          fmt::format("discrete variable {} has {} values, but a new factor takes it to "
                      "have {}",
                      to_string(key.key), known, key.cardinality));
    }
    if (estimate_.assignment.contains(key.key)) continue;
    estimate_.assignment.set(key.key, initial.contains(key.key) ? initial.at(key.key) : 0);
    undo.emplace_back([this, key] {
      estimate_.assignment.erase(key.key);
      cardinalities_.erase(key.key);
    });
  }
}

Eigen::MatrixXd BatchBackend::joint_covariance(const std::vector<Key>& keys) const {
  if (solve_every_ != 1) {
    throw SettingsError(
        "associating sightings with landmarks needs an estimate after each keyframe: set [solver] "
        "mode = incremental, or solve_every = 1 with mode = batch");
  }
  if (!marginals_) marginals_.emplace(graph_, estimate_);
  return marginals_->joint_covariance(keys);
}

BackendReport BatchBackend::finish() {
  BackendReport report = solve(estimate_);
  starts_.clear();
  const auto start = Clock::now();
  const ChordalTrial trial = try_chordal_start(graph_, estimate_, options_);
  report.seconds += seconds_since(start);
  if (!trial.tried) return report;
  starts_ = {{"objective_from_odometry", objective_}, {"objective_from_chordal", trial.objective}};
  if (!trial.better) return report;
  report.warnings.clear();
  add_work(report, solve(*trial.better));
  starts_["objective_from_chordal"] = objective_;
  return report;
}

BackendReport BatchBackend::solve(const Estimate& initial) {
  marginals_.reset();
  const auto start = Clock::now();
  AlternatingResult result = alternate(graph_, initial, options_);
  BackendReport report;
  std::size_t last_discrete = 0;  // half-step of all flips: `alternate` does not report the one of
                                  // each flip
  for (const HalfStep& half : result.report.half_steps) {
    if (half.discrete && half.changes > 0) last_discrete = report.objectives.size();
    report.objectives.push_back(half.objective);
    (half.discrete ? report.flips : report.rounds) += half.changes;
  }
  for (const auto& [key, value] : result.estimate.assignment) {
    const int before = estimate_.assignment.find(key);
    if (before != value) report.flipped.push_back({key, before, value, last_discrete});
  }
  report.relinearized = report.rounds > 0 ? static_cast<int>(estimate_.values.size()) : 0;
  estimate_ = std::move(result.estimate);
  objective_ = report.objective_after = result.report.objective;
  cost_ = report.cost = result.report.cost;
  is_solved_ = true;
  if (result.report.status != AlternatingStatus::kConverged) {
    report.warnings.push_back("the solver did not converge: " + result.report.message);
  }
  report.seconds = seconds_since(start);
  return report;
}

Uncertainty BatchBackend::uncertainty(const std::vector<Key>& continuous,
                                      const std::vector<DiscreteKey>& discrete) const {
  Uncertainty out;
  const auto marginals = [this]() -> const ContinuousMarginals& {
    if (!marginals_) marginals_.emplace(graph_, estimate_);
    return *marginals_;
  };
  if (!continuous.empty()) {
    const Covariances all = marginals().all();
    for (const Key key : continuous) {
      if (all.contains(key)) out.covariances[key] = all.at(key);
    }
  }
  if (discrete.empty()) return out;
  std::vector<Key> keys;
  for (const DiscreteKey& key : discrete) keys.push_back(key.key);
  const JointCovariance covariance = [&](const std::vector<Key>& some) {
    const std::vector<Key>& open = marginals().under_constrained();
    const bool determined = std::none_of(some.begin(), some.end(), [&](Key key) {
      return std::find(open.begin(), open.end(), key) != open.end();
    });
    return determined ? marginals().joint_covariance(some) : Eigen::MatrixXd();
  };
  add_probabilities(posterior_marginals(graph_, estimate_, keys, covariance), out);
  return out;
}

}  // namespace hybrid
