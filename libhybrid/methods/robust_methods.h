// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, the hybrid mapping authors
#pragma once

#include <string>
#include <vector>

#include "libhybrid/baselines/alternation.h"
#include "libhybrid/baselines/consistency.h"
#include "libhybrid/baselines/dcs.h"
#include "libhybrid/baselines/gnc.h"
#include "libhybrid/baselines/switchable.h"
#include "libhybrid/closures/problem.h"
#include "libhybrid/methods/portfolio.h"
#include "libhybrid/online/online_selection.h"
#include "libhybrid/pose_graph/pose_graph.h"

namespace HYBRID_API hybrid {

/// Settings of all robust methods.
struct MethodOptions {
  ComparisonOptions common;  ///< of methods without settings of their own: lm, max-mixture, ...
  GncOptions gnc;
  DcsOptions dcs;
  SwitchableOptions switchable;
  ConsistencyOptions consistency;
  AlternationOptions alternation;
  PortfolioOptions portfolio;  ///< its selection is also that of the method "selection"
  OnlineSelectionOptions online;

  /// Gives all methods the same model of false closures; online it is constant (see
  /// MixtureOptions::flat) except in evaluations of all closures.
  void set_mixture(const MixtureOptions& mixture);
  /// Threads of all solvers, see SolverOptions.
  void set_threads(int threads);
};

/// The input of a robust method.
struct RobustTask {
  RobustProblem problem;
  std::vector<bool> truth;  ///< whether each closure is true, if known: for "oracle"
  /// The graph from which the problem was made with odometry trusted, if there is one: for
  /// "online".
  PoseGraph graph;
};

/// A robust method and its name in all programs.
struct RobustMethod {
  std::string name;
  std::string old_name;  ///< deprecated, still accepted; empty if there is none
  std::string meaning;   ///< one line
  /// Throws Error if the task lacks an input of the method, and as the method does.
  RobustResult (*solve)(const RobustTask& task, const MethodOptions& options);
};

/// All methods: bounds, methods of others, ours.
const std::vector<RobustMethod>& robust_methods();

/// The method of that name, which may be an old one. Throws Error listing the names if there is
/// none.
const RobustMethod& robust_method(const std::string& name);

}  // namespace hybrid
