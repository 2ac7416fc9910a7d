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
#include "libhybrid/selection/online_closure_selection.h"
#include "libhybrid/selection/portfolio.h"
#include "mrpt_plugins/bridge/ini_file.h"

namespace HYBRID_API hybrid {

/// Settings of all robust methods.
struct MethodOptions {
  MixtureOptions mixture;
  GncOptions gnc;
  DcsOptions dcs;
  SwitchableOptions switchable;
  ConsistencyOptions consistency;
  AlternationOptions alternation;
  PortfolioOptions portfolio;  ///< of re-admission too
  OnlineClosureSelectionOptions online;
};

/// Names of methods, with one line each on what they are: those that solve_by_name takes, and
/// "online", which takes a pose graph.
struct MethodName {
  std::string name, meaning;
};
const std::vector<MethodName>& method_names();

/// Declares and reads the sections [mixture], [gnc], [dcs], [switchable], [consistency].
MethodOptions read_method_options(IniFile& ini);

/// Solves on one thread. `truth` tells which closures are true, which only "oracle" looks at.
/// Throws Error for an unknown name.
RobustResult solve_by_name(const std::string& name, const RobustProblem& problem,
                           const std::vector<bool>& truth, const MethodOptions& options);

}  // namespace hybrid
