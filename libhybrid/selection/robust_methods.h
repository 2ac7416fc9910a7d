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
#include "libhybrid/pose_graph/pose_graph.h"
#include "libhybrid/selection/online_closure_selection.h"
#include "libhybrid/selection/portfolio.h"

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
  OnlineClosureSelectionOptions online;

  /// Gives all methods the same model of false closures; online it is constant (see
  /// MixtureOptions::flat) save where all closures are evaluated again.
  void set_mixture(const MixtureOptions& mixture);
  /// Threads of all solvers, see SolverOptions.
  void set_threads(int threads);
};

/// What a robust method is given.
struct RobustTask {
  RobustProblem problem;
  std::vector<bool> truth;  ///< whether each closure is true, where known: for "oracle"
  /// The graph that the problem was made of with odometry trusted, where there is one: for
  /// "online".
  PoseGraph graph;
};

/// A robust method under the name that all programs know it by.
struct RobustMethod {
  std::string name;
  std::string old_name;  ///< still understood; empty if there is none
  std::string meaning;   ///< one line
  /// Throws Error where the task lacks what the method needs, and as the method does.
  RobustResult (*solve)(const RobustTask& task, const MethodOptions& options);
};

/// All methods: bounds, methods of others, ours.
const std::vector<RobustMethod>& robust_methods();

/// The method of that name, which may be an old one. Throws Error listing the names.
const RobustMethod& robust_method(const std::string& name);

}  // namespace hybrid
