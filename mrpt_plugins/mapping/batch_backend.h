// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, the hybrid mapping authors

#pragma once

#include <functional>
#include <map>
#include <optional>
#include <string>
#include <unordered_map>
#include <vector>

#include "libhybrid/marginals/continuous.h"
#include "libhybrid/solvers/alternating.h"
#include "mrpt_plugins/mapping/backend.h"

namespace HYBRID_API hybrid {

/// Collects the whole graph, with new variables at the initial values of the plugins. Solves it by
/// alternating minimisation at the end, and optionally every so many updates.
class BatchBackend : public Backend {
 public:
  /// Solves after every `solve_every` updates; 0: only in finish().
  BatchBackend(const AlternatingOptions& options, int solve_every);

  std::string mode() const override { return "batch"; }
  BackendReport update(const Delta& delta) override;
  BackendReport propose(const Proposal& proposal) override;
  BackendReport finish() override;
  std::map<std::string, double> statistics() const override { return starts_; }
  const Values& values() const override { return estimate_.values; }
  const Assignment& assignment() const override { return estimate_.assignment; }
  const HybridGraph& graph() const override { return graph_; }
  bool keeps_all() const override { return true; }
  bool holds(Key key) const override { return estimate_.values.contains(key); }
  Eigen::MatrixXd joint_covariance(const std::vector<Key>& keys) const override;
  using Backend::joint_covariance;
  Uncertainty uncertainty(const std::vector<Key>& continuous,
                          const std::vector<DiscreteKey>& discrete) const override;

 private:
  using Undo = std::vector<std::function<void()>>;

  AddedHandles insert(const Delta& delta, Undo& undo);
  void add_discrete(const std::vector<DiscreteKey>& keys, const Assignment& initial, Undo& undo);
  BackendReport solve(const Estimate& initial);

  AlternatingOptions options_;
  int solve_every_;
  int updates_ = 0;
  HybridGraph graph_;
  Estimate estimate_;
  std::unordered_map<Key, int> cardinalities_;  // of all discrete variables ever added
  double objective_ = 0;
  double cost_ = 0;
  bool is_solved_ = true;                 // since the last change
  std::map<std::string, double> starts_;  // objectives of those that the last finish() compared
  mutable std::optional<ContinuousMarginals> marginals_;  // at the estimate; computed on demand
};

}  // namespace hybrid
