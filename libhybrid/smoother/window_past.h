// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, the hybrid mapping authors
#pragma once

#include <unordered_map>
#include <utility>
#include <vector>

#include "libhybrid/smoother/past_states.h"

namespace HYBRID_API hybrid {

/// What is kept of variables that have left a window.
class WindowPast {
 public:
  /// Last estimates.
  const Estimate& estimate() const { return estimate_; }
  /// All that was known of a discrete variable, zero at its last value; null where nothing is kept.
  const Table* table(Key key) const;
  /// Covariance of a state; null for any other variable.
  const Eigen::MatrixXd* covariance(Key key) const;
  /// States moved along with what they were tied to, see PastStates.
  Values states(const Values& window) const { return states_.at(window, covariances_); }
  Values moved_states(const Values& window, const std::vector<Key>& changed) {
    return states_.follow(window, changed, covariances_);
  }

  /// The change with those variables that its factors hold although they have left; the tables of
  /// discrete ones come last.
  Delta with_returning(const Delta& delta) const;
  /// Forgets those that have entered again: `change` is the delta with them.
  void forget_returned(const Delta& delta, const Delta& change);

  void leave(Key key, VariableType type, const double* x) { estimate_.values.insert(key, type, x); }
  void leave(Key key, int value, Table table);
  /// States, with their joint covariance in the order of their keys.
  void leave(const std::vector<Key>& keys, const Eigen::MatrixXd& joint,
             PastStates::Departure places);

 private:
  Estimate estimate_;
  std::unordered_map<Key, Table> tables_;
  PastStates states_;
  std::unordered_map<Key, Eigen::MatrixXd> covariances_;
};

}  // namespace hybrid
