// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, the hybrid mapping authors

#include "mrpt_plugins/mapping/batch_backend.h"

#include <chrono>
#include <utility>

#include "libhybrid/core/elapsed.h"
#include "libhybrid/discrete/inference.h"
#include "libhybrid/marginals/continuous.h"

namespace hybrid {
namespace {

using Clock = std::chrono::steady_clock;

/// What a change adds to objective and cost at the present estimate.
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

/// The discrete factors that remain at the estimate (eq. 8a).
std::vector<Table> tables_at(const HybridGraph& graph, const Values& values) {
  std::vector<Table> tables;
  graph.discrete().for_each([&](Handle, const Table& table) { tables.push_back(table); });
  graph.hybrid().for_each([&](Handle, const HybridFactorPtr& factor) {
    for (Table& table : factor->given(values)) tables.push_back(std::move(table));
  });
  return tables;
}

/// Laplace covariances of some variables (eq. 12); none where the system is singular.
void add_covariances(const HybridGraph& graph, const Estimate& at, const std::vector<Key>& keys,
                     Uncertainty& out) {
  if (keys.empty()) return;
  MarginalOptions options;
  options.weak = WeakComponents::kUncoupled;
  const ContinuousMarginals marginals(graph, at, options);
  if (!marginals.valid()) return;
  const Covariances all = marginals.all();
  for (const Key key : keys) out.covariances[key] = all.at(key);
}

}  // namespace

BatchBackend::BatchBackend(const AlternatingOptions& options, int solve_every)
    : options_(options), solve_every_(solve_every) {}

BackendReport BatchBackend::update(const Delta& delta) {
  const auto start = Clock::now();
  marginals_.reset();
  BackendReport report;
  report.handles = insert(delta);
  ++updates_;
  if (solve_every_ > 0 && updates_ % solve_every_ == 0) {
    BackendReport solved = solve();
    solved.handles = std::move(report.handles);
    return solved;
  }
  if (delta.remove.empty()) {
    add_to(delta, estimate_, objective_, cost_);
  } else {
    objective_ = objective(graph_, estimate_.values, estimate_.assignment);
    cost_ = cost(graph_, estimate_.values, estimate_.assignment);
  }
  report.objective = objective_;
  report.cost = cost_;
  report.seconds = seconds_since(start);
  return report;
}

std::vector<Handle> BatchBackend::insert(const Delta& delta) {
  std::vector<Handle> handles;
  for (const Handle handle : delta.remove) graph_.remove(handle);
  for (const Key key : delta.remove_values) estimate_.values.erase(key);
  for (const Key key : delta.values.keys()) {
    estimate_.values.insert(key, delta.values.type(key), delta.values.data(key));
  }
  const auto add_discrete = [&](const std::vector<DiscreteKey>& keys) {
    for (const DiscreteKey& key : keys) {
      if (estimate_.assignment.contains(key.key)) continue;
      const bool given = delta.assignment.contains(key.key);
      estimate_.assignment.set(key.key, given ? delta.assignment.at(key.key) : 0);
    }
  };
  for (const ContinuousFactorPtr& factor : delta.continuous) handles.push_back(graph_.add(factor));
  for (const Table& table : delta.discrete) {
    add_discrete(table.keys());
    handles.push_back(graph_.add(table));
  }
  for (const HybridFactorPtr& factor : delta.hybrid) {
    add_discrete(factor->discrete_keys());
    handles.push_back(graph_.add(factor));
  }
  return handles;
}

Eigen::MatrixXd BatchBackend::joint_covariance(const std::vector<Key>& keys) const {
  if (solve_every_ != 1) {
    throw Error(
        "associating sightings with landmarks needs an estimate after each keyframe: set [solver] "
        "mode = incremental, or solve_every = 1 with mode = batch");
  }
  if (!marginals_) marginals_.emplace(graph_, estimate_);
  return marginals_->joint_covariance(keys);
}

BackendReport BatchBackend::solve() {
  marginals_.reset();
  const auto start = Clock::now();
  AlternatingResult result = alternate(graph_, estimate_, options_);
  BackendReport report;
  for (const HalfStep& half : result.report.half_steps) {
    report.half_steps.push_back(half.objective);
    (half.discrete ? report.flips : report.iterations) += half.changes;
  }
  report.relinearized = static_cast<int>(estimate_.values.size());
  estimate_ = std::move(result.estimate);
  objective_ = report.objective = result.report.objective;
  cost_ = report.cost = result.report.cost;
  if (result.report.status != AlternatingStatus::kConverged) {
    report.warnings.push_back("the solver did not converge: " + result.report.message);
  }
  report.seconds = seconds_since(start);
  return report;
}

Uncertainty BatchBackend::uncertainty(const std::vector<Key>& continuous,
                                      const std::vector<DiscreteKey>& discrete) const {
  Uncertainty out;
  add_covariances(graph_, estimate_, continuous, out);
  if (discrete.empty()) return out;
  const std::vector<Table> tables = tables_at(graph_, estimate_.values);
  std::vector<const Table*> pointers;
  for (const Table& table : tables) pointers.push_back(&table);
  const DiscreteMarginals marginals = discrete_marginals(pointers);
  for (const DiscreteKey& key : discrete) {
    const auto p = marginals.at(key.key);
    out.probabilities[key.key].assign(p.data(), p.data() + p.size());
  }
  return out;
}

}  // namespace hybrid
