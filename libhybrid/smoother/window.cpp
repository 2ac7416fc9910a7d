// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, the hybrid mapping authors
#include "libhybrid/smoother/window.h"

#include <algorithm>
#include <utility>

namespace hybrid {
namespace {

bool is_pose(VariableType type) {
  return type.kind == VariableKind::kSE2 || type.kind == VariableKind::kSE3;
}

void sort_unique(std::vector<Key>& keys) {
  std::sort(keys.begin(), keys.end());
  keys.erase(std::unique(keys.begin(), keys.end()), keys.end());
}

}  // namespace

WindowReport WindowSmoother::update(const Delta& delta) {
  WindowReport report;
  static_cast<UpdateReport&>(report) = smoother_.update(delta);
  if (report.status != UpdateReport::Status::kOk || window_.mode == WindowOptions::Mode::kFull)
    return report;
  ++updates_;
  touch(delta, report.handles);
  const std::vector<Key> keys = outdated(delta);
  if (!keys.empty()) leave(keys, report);
  return report;
}

void WindowSmoother::touch(const Delta& delta, const std::vector<Handle>& handles) {
  for (Key key : delta.values.keys()) last_touch_[key] = updates_;
  const HybridGraph& graph = smoother_.graph();
  for (Handle handle : handles) {
    if (handle.kind == FactorKind::kContinuous) {
      for (Key key : graph.continuous().at(handle)->keys()) last_touch_[key] = updates_;
    } else if (handle.kind == FactorKind::kHybrid) {
      for (Key key : graph.hybrid().at(handle)->keys()) last_touch_[key] = updates_;
    }
  }
}

/// The variables that leave the window now, in a fixed order.
std::vector<Key> WindowSmoother::outdated(const Delta& delta) const {
  std::vector<Key> keys;
  const bool filter = window_.mode == WindowOptions::Mode::kFilter;
  if (!filter && window_.lag <= 0) return keys;
  bool new_pose = false;
  for (Key key : delta.values.keys()) new_pose = new_pose || is_pose(delta.values.type(key));
  for (const auto& [key, update] : last_touch_) {
    if (!filter && update <= updates_ - window_.lag) keys.push_back(key);
    if (filter && new_pose && is_pose(smoother_.values().type(key)) &&
        !delta.values.contains(key)) {
      keys.push_back(key);
    }
  }
  sort_unique(keys);
  return keys;
}

/// Sums the new single-variable tables with those left before, so that their number does not grow.
void WindowSmoother::gather_tables(Delta& delta) const {
  for (Table& table : delta.discrete) {
    if (table.keys().size() != 1) continue;
    const auto before = table_.find(table.keys()[0].key);
    if (before == table_.end()) continue;
    std::vector<double> costs = table.costs();
    const std::vector<double>& old = smoother_.graph().discrete().at(before->second).costs();
    for (std::size_t i = 0; i < costs.size(); ++i) costs[i] += old[i];
    table = Table(table.keys(), std::move(costs));
    delta.remove.push_back(before->second);
  }
}

void WindowSmoother::leave(const std::vector<Key>& keys, WindowReport& report) {
  std::vector<Handle> factors;
  std::vector<Key> discrete;
  for (Key key : keys) {
    for (Handle handle : smoother_.factors_of(key)) {
      if (std::find(factors.begin(), factors.end(), handle) != factors.end()) continue;
      factors.push_back(handle);
      if (handle.kind != FactorKind::kHybrid) continue;
      for (const DiscreteKey& d : smoother_.graph().hybrid().at(handle)->discrete_keys())
        discrete.push_back(d.key);
    }
  }
  Marginalization change =
      marginalize(smoother_.graph(), smoother_.values(), smoother_.assignment(), keys, factors);
  if (!change.determined) return;  // it stays until its factors determine it
  gather_tables(change.delta);
  sort_unique(discrete);
  for (Key key : discrete) past_.assignment.set(key, smoother_.assignment().at(key));
  Values left;
  for (Key key : keys) left.insert(key, smoother_.values().type(key), smoother_.values().data(key));
  const UpdateReport done = smoother_.update(change.delta);
  if (done.status != UpdateReport::Status::kOk) return;
  for (Key key : keys) {
    past_.values.insert(key, left.type(key), left.data(key));
    last_touch_.erase(key);
  }
  for (Handle handle : done.handles) {
    if (handle.kind != FactorKind::kDiscrete) continue;
    const Table& table = smoother_.graph().discrete().at(handle);
    if (table.keys().size() == 1) table_[table.keys()[0].key] = handle;
  }
  report.marginalized += static_cast<int>(keys.size());
  report.fill += change.fill;
  report.seconds += done.seconds;
  report.objective_after = done.objective_after;
}

}  // namespace hybrid
