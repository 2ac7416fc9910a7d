// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, the hybrid mapping authors
#include "libhybrid/smoother/window_past.h"

#include <algorithm>

namespace hybrid {

const Table* WindowPast::table(Key key) const {
  const auto it = tables_.find(key);
  return it == tables_.end() ? nullptr : &it->second;
}

const Eigen::MatrixXd* WindowPast::covariance(Key key) const {
  const auto it = covariances_.find(key);
  return it == covariances_.end() ? nullptr : &it->second;
}

Delta WindowPast::with_returning(const Delta& delta) const {
  Delta out = delta;
  const auto recall = [&](const std::vector<Key>& keys) {
    for (Key key : keys) {
      if (out.values.contains(key) || !estimate_.values.contains(key)) continue;
      out.values.insert(key, estimate_.values.type(key), estimate_.values.data(key));
    }
  };
  std::vector<Key> recalled;
  const auto recall_discrete = [&](const std::vector<DiscreteKey>& keys) {
    for (const DiscreteKey& key : keys) {
      if (!estimate_.assignment.contains(key.key)) continue;
      if (std::find(recalled.begin(), recalled.end(), key.key) != recalled.end()) continue;
      recalled.push_back(key.key);
      out.assignment.set(key.key, estimate_.assignment.at(key.key));
      if (const Table* table = this->table(key.key)) out.discrete.push_back(*table);
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

void WindowPast::forget_returned(const Delta& delta, const Delta& change) {
  for (Key key : change.values.keys()) {
    if (estimate_.values.contains(key)) estimate_.values.erase(key);
  }
  const auto forget = [&](const std::vector<DiscreteKey>& keys) {
    for (const DiscreteKey& key : keys) {
      estimate_.assignment.erase(key.key);
      tables_.erase(key.key);
    }
  };
  for (const Table& table : delta.discrete) forget(table.keys());
  for (const HybridFactorPtr& factor : delta.hybrid) forget(factor->discrete_keys());
}

void WindowPast::leave(Key key, int value, Table table) {
  estimate_.assignment.set(key, value);
  if (!table.keys().empty()) tables_[key] = std::move(table);
}

void WindowPast::leave(const std::vector<Key>& keys, const Eigen::MatrixXd& joint,
                       PastStates::Departure places) {
  Eigen::Index at = 0;
  for (Key key : keys) {
    const int dim = estimate_.values.type(key).dim;
    covariances_[key] = joint.block(at, at, dim, dim);
    at += dim;
  }
  states_.leave(std::move(places));
}

}  // namespace hybrid
